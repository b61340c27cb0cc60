// A running robot: its torque and what the model leaves of it, recordings, motions.
import { h, head, number } from "./dom.js";
import { ask, current, say } from "./link.js";
import { Motions, waits } from "./send.js";
import { Stream } from "./stream.js";

export const TITLE = "Live";
const stream = new Stream();
const kept = { source: null, status: null, picked: null };
let refresh = () => {};

export function listed(state) {
  return Boolean(state.live);
}

export function status({ live }) {
  if (live.error) {
    return "not connected";
  }
  return live.recording !== null ? "recording" : live.joints ? `${live.joints} joints` : "nothing heard yet";
}

const does = (what) => ask(what, {}, "api/live/");

// What every step shows: that it records, and the button that stops a motion.
export function banner({ live }) {
  const place = document.getElementById("robot");
  const motion = live && live.motion, recording = live && live.recording !== null;
  const kinds = [recording, Boolean(motion)].join();
  if (place.dataset.kinds !== kinds) {
    place.dataset.kinds = kinds;
    place.replaceChildren(
      ...(recording ? [h("span", { class: "recorded" })] : []),
      ...(motion ? [h("span", { class: "moved" }), h("button", { class: "main danger", "data-key": "halt", onclick: () => does("stop") }, "Stop the motion")] : []));
    if (motion && waits.stop) {
      place.querySelector("button").focus();
    }
    waits.stop = false;
  }
  if (recording) {
    place.querySelector(".recorded").textContent = `● recording, ${live.recording} s`;
  }
  if (motion) {
    place.querySelector(".moved").textContent = `${motion.name.replaceAll("_", " ")}: ${motion.elapsed} of ${Math.round(motion.seconds)} s`;
  }
}

// Events come only while the step is shown: a browser opens few connections to one server.
function connect() {
  if (kept.source) {
    return;
  }
  kept.source = new EventSource("api/live");
  kept.source.onmessage = (event) => {
    if (location.hash !== "#live") {
      kept.source.close();
      kept.source = null;
      stream.past.clear();
      return;
    }
    const told = JSON.parse(event.data);
    if (told.event === "samples") {
      stream.add(told);
    } else {
      kept.status = told;
    }
    refresh();
  };
}

function connection(now) {
  if (!now || (!now.topic && !now.error)) {
    return "Connecting to the ROS graph…";
  }
  if (now.error) {
    return "Not connected.";
  }
  if (!now.joints.length) {
    return `No joint states on ${now.topic}: ${now.publishers ? "its publisher is silent" : "nobody publishes there"}.`;
  }
  const late = now.delay ? `; residuals ${Math.round(1000 * now.delay)} ms late` : "";
  return `${now.topic}, ${number(now.rate)} Hz, ${now.joints.length} joints${late}`;
}

function picks() {
  const joints = [...stream.past.joints.keys()];
  if (!kept.picked) {
    kept.picked = new Set(joints.slice(0, 3));
  }
  if (!joints.some((joint) => kept.picked.has(joint))) {
    joints.slice(0, 3).forEach((joint) => kept.picked.add(joint));
  }
  stream.shown = kept.picked;
  return joints.map((joint) => {
    const pick = h("button", { class: "pick", "aria-pressed": String(kept.picked.has(joint)), "data-key": "live" + joint, onclick: () => {
      if (kept.picked.has(joint) && kept.picked.size > 1) {
        kept.picked.delete(joint);
      } else {
        kept.picked.add(joint);
      }
      pick.setAttribute("aria-pressed", String(kept.picked.has(joint)));
      stream.draw();
    } }, joint);
    return pick;
  });
}

// The residual of the last seconds beside the error on unseen motion, updated in place.
class Residuals {
  constructor(state) {
    this.node = current(state);
    this.cells = new Map();
    this.body = h("tbody", {});
    this.table = h("table", {}, h("thead", {}, h("tr", {}, h("th", {}, "joint"), h("th", { class: "number" }, "now"),
      h("th", { class: "number" }, "unseen"), h("th", { class: "number" }, "ratio"))), this.body);
    this.words = h("p", { class: "quiet under" });
    this.element = h("section", { class: "card" }, h("h3", {}, "Residual [N·m]"), this.table, this.words);
  }

  show(rms) {
    const joints = Object.keys(rms || {});
    this.table.hidden = !joints.length;
    const words = joints.length ? "Rms of the last 5 s beside the error on unseen motion. A joint that hardly moves is not judged."
      : this.node ? "It waits for joint states." : "Learn a model first: until then the measured torque alone is drawn.";
    if (this.words.textContent !== words) {
      this.words.textContent = words;
    }
    for (const joint of joints) {
      if (!this.cells.has(joint)) {
        const cells = [0, 1, 2].map(() => h("td", { class: "number" }));
        this.cells.set(joint, cells);
        this.body.append(h("tr", {}, h("td", {}, joint), cells));
      }
      const unseen = this.node?.compared?.joints[joint]?.rmse, now = rms[joint];
      const ratio = now !== null && unseen ? now / unseen : null;
      const [first, second, third] = this.cells.get(joint);
      first.textContent = number(now);
      second.textContent = number(unseen);
      third.textContent = ratio === null ? "–" : number(Number(ratio.toPrecision(2)));
      third.classList.toggle("bad", ratio !== null && ratio > 2);
    }
  }
}

export function view(state, { go }) {
  connect();
  const line = h("span", {}), warnings = h("div", { role: "status" }), joints = h("div", { class: "row", role: "group", "aria-label": "joints that are shown" });
  const again = h("button", { class: "plain", "data-key": "again", hidden: true, onclick: () => does("connect") }, "Connect again");
  const record = h("button", { class: "main", "data-key": "record", disabled: true, onclick: async () => {
    const stops = record.dataset.stops === "true";
    record.disabled = true;
    const done = await does(stops ? "finish" : "record");
    if (done) {
      const early = done.ended ? ` It ended early: ${done.ended}.` : "";
      say(stops ? `${number(done.seconds)} s were recorded; they are a card under Data.${early}` : "");
    }
  } }, "Start recording");
  const tally = h("span", { class: "quiet" });
  const motions = new Motions(state), residuals = new Residuals(state), canvas = stream.place();
  const empty = h("div", { class: "empty" });
  const legend = h("p", { class: "quiet" });
  let known = "", warned = "", recorded = null;
  refresh = () => {
    const now = kept.status;
    line.textContent = connection(now);
    if (!now) {
      return;
    }
    again.hidden = !now.error;
    const heard = now.joints || [], names = [...stream.past.joints.keys()].join();
    if (names !== known) {
      known = names;
      joints.replaceChildren(...picks());
    }
    const told = JSON.stringify([now.error, now.warnings]);
    if (told !== warned) {
      warned = told;
      warnings.replaceChildren(...[now.error, ...(now.warnings || [])].filter(Boolean).map((text) => h("p", { class: "bad" }, text[0].toUpperCase() + text.slice(1) + ".")));
    }
    const running = Boolean(now.recording);
    if (recorded !== running || now.error) {
      recorded = running;
      record.dataset.stops = String(running);
      record.textContent = running ? "Stop recording" : "Start recording";
    }
    record.disabled = !running && !heard.length;
    tally.textContent = running ? `${number(now.recording.seconds)} s, ${now.recording.samples} samples` : "";
    motions.show(now);
    residuals.show(now.rms);
    const drawn = stream.past.joints.size > 0;
    empty.hidden = drawn;
    canvas.hidden = legend.hidden = !drawn;
    empty.replaceChildren(h("h3", {}, now.error ? "Not connected" : "Nothing to draw yet"),
      now.error ? "The rest of the workbench works without it." : heard.length ? "The filter settles, or the joint states have no effort." : "It is drawn as soon as joint states come.");
    const words = stream.past.names.includes("residual")
      ? "Grey: measured. Blue: predicted. Below them the residual, measured less predicted. Every peak stays." : "Measured torque.";
    if (legend.textContent !== words) {
      legend.textContent = words;
    }
  };
  const parts = [head("Live", line, tally, again, record), warnings,
    h("div", { class: "two beside" }, h("section", {}, joints, empty, canvas, legend), h("div", {}, residuals.element, motions.element))];
  refresh(); // before it is shown: what is disabled cannot take the focus back
  queueMicrotask(() => stream.draw());
  return parts;
}
