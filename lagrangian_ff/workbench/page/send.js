// A motion is sent: what it would do is said first, and only a click on Send does it.
import { h, number } from "./dom.js";
import { ask } from "./link.js";

const kept = { motion: "", topic: "" };
// Whether a motion was sent here, so that the button that stops it is to have the focus.
export const waits = { stop: false };

function angle(value) {
  return value.toFixed(3).replace(/^-(0\.0+)$/, "$1");
}

function names(list) {
  return list.length ? list.join(", ") : "none";
}

// How the arm gets to the start of the motion, in words.
function way(found) {
  const far = Math.max(...found.moved.map(Math.abs));
  if (far < 0.01) {
    return `The arm stands at the start. It waits there for ${number(found.way)} s.`;
  }
  const moves = found.joints.map((joint, n) => [joint, found.moved[n]]).filter(([, by]) => Math.abs(by) >= 0.01)
    .map(([joint, by]) => `${joint} by ${angle(by)}`);
  return `First a slow move to the start, ${number(found.way)} s at 0.3 rad/s at most, straight in joint angles: ${moves.join(", ")} rad. See that this way is free.`;
}

function confirm(found, motion) {
  const before = document.activeElement?.dataset.key;
  const rows = [["Arm", names(found.joints)], ["Topic", found.topic], ["Who takes it", names(found.nodes)],
    ["Duration", `${number(found.seconds)} s, of them ${number(found.way)} s on the way to its start`],
    ["Way to the start", way(found)]];
  const send = h("button", { class: "main danger", onclick: async () => {
    send.disabled = true;
    waits.stop = true;
    const done = await ask("send", { token: found.token, motion: found.motion, topic: found.topic }, "api/live/");
    waits.stop = waits.stop && Boolean(done);
    close();
  } }, "Send");
  const dialog = h("dialog", { "aria-labelledby": "confirm-title", "aria-describedby": "confirm-care" },
    h("h2", { id: "confirm-title" }, `Move the arm: ${motion}?`),
    h("dl", {}, rows.map(([term, words]) => [h("dt", {}, term), h("dd", {}, words)])),
    h("table", {}, h("thead", {}, h("tr", {}, h("th", {}, "joint"), h("th", { class: "number" }, "is at [rad]"),
      h("th", { class: "number" }, "motion begins at [rad]"), h("th", { class: "number" }, "fastest [rad/s]"))),
      h("tbody", {}, found.joints.map((joint, n) => h("tr", {}, h("td", {}, joint),
        h("td", { class: "number" }, angle(found.start[n] - found.moved[n])), h("td", { class: "number" }, angle(found.start[n])),
        h("td", { class: "number" }, number(found.fastest[n])))))),
    found.notes.map((note) => h("p", { class: "quiet" }, note)),
    h("p", { id: "confirm-care" }, "Have the emergency stop at hand. This page is no safety function: the controller's own limits hold."),
    h("div", { class: "row" }, h("button", { class: "plain", autofocus: true, onclick: () => close() }, "Do not send"), send));
  const close = () => dialog.close();
  dialog.addEventListener("close", () => {
    dialog.remove();
    if (before && document.activeElement === document.body) {
      document.querySelector(`[data-key="${CSS.escape(before)}"]`)?.focus();
    }
  });
  document.body.append(dialog);
  dialog.showModal();
}

function options(values, chosen) {
  return values.map(([value, words]) => h("option", { value, selected: value === chosen }, words));
}

// The card with motions and topics; `show` takes each status.
export class Motions {
  constructor(state) {
    this.titles = new Map((state.motions || []).map((one) => [String(one.file).split("/").at(-1), one.title]));
    this.motion = h("select", { class: "pick", "data-key": "motion", onchange: () => (kept.motion = this.motion.value) });
    this.topic = h("select", { class: "pick", "data-key": "topic", onchange: () => (kept.topic = this.topic.value) });
    this.send = h("button", { class: "plain", "data-key": "prepare", disabled: true, onclick: () => this.prepare() }, "Send…");
    this.words = h("p", { class: "quiet under" });
    this.listed = "";
    this.form = h("div", { class: "stack" }, h("label", {}, "motion ", this.motion), h("label", {}, "to ", this.topic));
    this.element = h("section", { class: "card" }, h("h3", {}, "Send a motion"), this.form, this.send, this.words);
  }

  async prepare() {
    this.send.disabled = true;
    const asked = { motion: this.motion.value, topic: this.topic.value };
    const found = await ask("prepare", asked, "api/live/");
    this.send.disabled = false;
    this.send.focus();
    if (found) {
      confirm(found, this.title(asked.motion));
    }
  }

  title(file) {
    return this.titles.get(file) || file.replace(/\.csv$/, "").replaceAll("_", " ");
  }

  show(status) {
    const motions = status.motions || [], topics = status.topics || [];
    const listed = JSON.stringify([motions, topics, status.motion !== null]);
    if (listed === this.listed) {
      return;
    }
    this.listed = listed;
    this.motion.replaceChildren(...options(motions.map((file) => [file, this.title(file)]), kept.motion));
    this.topic.replaceChildren(...options(topics.map(({ topic }) => [topic, topic]), kept.topic));
    const ready = motions.length > 0 && topics.length > 0;
    this.form.hidden = this.send.hidden = !ready;
    this.send.disabled = Boolean(status.motion);
    this.words.textContent = !motions.length
      ? `There is no motion in this session. lagrangian_ff excite writes one: give it --output ${status.folder}/NAME.csv.`
      : !topics.length
        ? "Nobody in the graph takes a trajectory (trajectory_msgs/JointTrajectory)."
        : "What it would do is said before anything moves.";
  }
}
