// A motion is sent: what it would do is said first, and only a click on Send does it.
import { h, number } from "./dom.js";
import { ask } from "./link.js";
import { angle, confirm, names } from "./confirm.js";

const kept = { motion: "", topic: "" };
// Whether a motion was sent here, so that the button that stops it is to have the focus.
export const waits = { stop: false };

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

function asked(found, motion) {
  confirm({
    title: `Move the arm: ${motion}?`,
    rows: [["Arm", names(found.joints)], ["Topic", found.topic], ["Who takes it", names(found.nodes)],
      ["Duration", `${number(found.seconds)} s, of them ${number(found.way)} s on the way to its start`],
      ["Way to the start", way(found)]],
    header: ["joint", "is at [rad]", "motion begins at [rad]", "fastest [rad/s]"],
    joints: found.joints.map((joint, n) => [joint, angle(found.start[n] - found.moved[n]), angle(found.start[n]), number(found.fastest[n])]),
    notes: found.notes,
    no: { words: "Do not send" },
    yes: { words: "Send", act: async () => {
      waits.stop = true;
      const done = await ask("send", { token: found.token, motion: found.motion, topic: found.topic }, "api/live/");
      waits.stop = waits.stop && Boolean(done);
    } },
  });
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
    const question = { motion: this.motion.value, topic: this.topic.value };
    const found = await ask("prepare", question, "api/live/");
    this.send.disabled = false;
    document.querySelector('[data-key="prepare"]')?.focus(); // the view may have been made again meanwhile
    if (found) {
      asked(found, this.title(question.motion));
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
