// Measured and predicted torque of the joints on one time axis, the residual below.
import { h, head, number } from "./dom.js";
import { current } from "./link.js";
import { Curves, kept } from "./curves.js";
import { ErrorMap } from "./map.js";
import { saver } from "./save.js";
import { Arm, stick } from "./arm.js";

export const TITLE = "Compare";

export function status(state) {
  const node = current(state);
  return node && node.compared ? `${number(node.compared.rmse)} N·m unseen` : "where does it fail?";
}

export function view(state, { go }) {
  const node = current(state);
  if (!node || !node.compared) {
    return [head("Where does it fail?", "Measured and predicted torque on motion that the model has not seen."),
      h("div", { class: "empty" }, h("h3", {}, node ? "It is being compared" : "No model yet"), node ? "One moment." : "Learn a model first.")];
  }
  const names = node.compared.joint_names;
  if (!kept.joints || ![...kept.joints].every((name) => names.includes(name))) {
    kept.joints = new Set(names.slice(0, window.innerHeight > 1200 ? 6 : 3));
  }
  const seconds = node.compared.seconds;
  if (kept.node !== node.id || !kept.window) {
    kept.window = kept.window && kept.node && kept.window[1] <= seconds ? kept.window : [0, seconds];
    kept.node = node.id;
    kept.spans = [];
  }
  let map = null;
  const marked = h("p", { class: "quiet", "aria-live": "polite" });
  // Marks samples everywhere; the map lights up unless they were chosen on it.
  const choose = (spans, words, onMap = false) => {
    kept.spans = spans;
    kept.words = words;
    const length = spans.reduce((sum, [from, to]) => sum + to - from, 0);
    marked.textContent = spans.length ? `Marked: ${words}; ${number(length)} s in ${spans.length} stretch${spans.length > 1 ? "es" : ""}.` : "";
    if (spans.length) {
      const longest = spans.reduce((a, b) => (b[1] - b[0] > a[1] - a[0] ? b : a));
      kept.cursor = (longest[0] + longest[1]) / 2;
    }
    curves.draw();
    if (!onMap) {
      map?.light(spans);
    }
  };
  const curves = new Curves(node, seconds, choose);
  const arm = new Arm(state.skeleton.length ? state.skeleton : stick(names));
  const play = h("button", { class: "plain", "data-key": "play", onclick: () => {
    const playing = play.textContent === "Stop";
    play.textContent = playing ? "Play" : "Stop";
    let before = null;
    const step = (now) => {
      if (play.textContent !== "Stop" || !play.isConnected) {
        return;
      }
      kept.cursor = (kept.cursor ?? kept.window[0]) + (before === null ? 0 : (now - before) / 1000);
      if (kept.cursor > kept.window[1] || kept.cursor < kept.window[0]) {
        kept.cursor = kept.window[0];
      }
      before = now;
      curves.draw();
      requestAnimationFrame(step);
    };
    if (!playing) {
      requestAnimationFrame(step);
    }
  } }, "Play");
  curves.posed = (positions) => arm.pose(positions);
  const picks = names.map((name) => {
    const pick = h("button", { class: "pick", "aria-pressed": String(kept.joints.has(name)), "data-key": "joint" + name, onclick: () => {
      if (kept.joints.has(name) && kept.joints.size > 1) {
        kept.joints.delete(name);
      } else {
        kept.joints.add(name);
      }
      pick.setAttribute("aria-pressed", String(kept.joints.has(name)));
      curves.draw();
    } }, name);
    return pick;
  });
  const regions = node.compared.regions.slice(0, 8).map((one, k) =>
    h("li", {}, h("button", { class: "pick", "data-key": "region" + k, onclick: () => {
      kept.joints = new Set([one.joint]);
      picks.forEach((pick, n) => pick.setAttribute("aria-pressed", String(kept.joints.has(names[n]))));
      choose(one.spans, one.words);
    } }, one.words)));
  const worst = names.reduce((a, b) => (node.compared.joints[a].nmse > node.compared.joints[b].nmse ? a : b));
  map = new ErrorMap(node, regions.length ? node.compared.regions[0].joint : worst, (spans, words) => choose(spans, words, true));
  choose(kept.spans, kept.words);
  const drags = [["zoom", false], ["mark", true]].map(([label, marks]) =>
    h("button", { class: "pick small", "aria-pressed": String(kept.marks === marks), "data-key": label, onclick: (event) => {
      kept.marks = marks;
      event.target.parentElement.querySelectorAll("button").forEach((one) => one.setAttribute("aria-pressed", String(one === event.target)));
    } }, label));
  return [
    head("Where does it fail?", node.compared.words[0] || "The error is spread evenly over the motion.",
      h("button", { class: "main", "data-key": "next", onclick: () => go("diagnose") }, "Find what is missing")),
    h("div", { class: "two" },
      h("section", {}, h("div", { class: "row", role: "group", "aria-label": "joints that are shown" }, picks), 
        h("div", { class: "lead-up row" }, h("span", { class: "row", role: "group", "aria-label": "what a drag in the curves does" }, h("span", { class: "quiet" }, "drag to"), drags), curves.readout, saver(curves.canvas, "torque")), curves.canvas,
        h("p", { class: "quiet" }, "Grey: measured. Blue: predicted, with its 90 % interval. Below them the residual, measured less predicted."), marked),
      h("div", {}, h("section", { class: "card" }, h("h3", {}, "Where most of the error lies"),
        regions.length ? h("ul", { class: "regions" }, regions) : h("p", { class: "quiet" }, "Nowhere in particular.")),
        h("section", { class: "card" }, h("h3", {}, "The arm at the cursor"), arm.canvas, play,
          state.skeleton.length ? null : h("p", { class: "quiet" }, "A stick figure: which way the axes point is not known. Start the workbench with --urdf FILE to see the arm as it is.")),
        h("section", { class: "card" }, h("h3", {}, "Error over two quantities"), map.element, saver(map.canvas, "error_map")))),
  ];
}
