// What was added, and the error after each step.
import { h, head, number } from "./dom.js";
import { ask, current } from "./link.js";
import { line, stairs } from "./figures.js";
import { saver } from "./save.js";

export const TITLE = "Steps";

export function status(state) {
  const steps = line(state).length;
  return steps > 1 ? `${steps - 1} added` : "watch the error fall";
}

function branch(state, parent, root) {
  const children = state.nodes.filter((node) => node.parent === parent);
  if (!children.length) {
    return null;
  }
  return h("ul", { class: root ? "tree root" : "tree" }, children.map((node) =>
    h("li", {}, h("button", { class: "pick", "data-key": node.id, "aria-current": node.id === state.current ? "true" : null,
      onclick: () => ask("look", { model: node.id }) },
      `${node.title}${node.compared ? ` – ${number(node.compared.rmse)} N·m` : ""}`), branch(state, node.id, false))));
}

// The evidence for the effect that a step added.
function evidence(node) {
  const { verdict, evidence_gain: gain, p_value: p } = node.why;
  if (gain === undefined) {
    return node.parent ? "by hand" : "–";
  }
  return `${verdict}, log Bayes factor ${number(gain)}` + (p === null || p === undefined ? "" : `, p ${number(p)}`);
}

const pair = { a: "", b: "" };

// Two models beside each other, on the motion that both were judged on.
function versus(state) {
  const known = state.nodes.filter((node) => node.compared);
  if (known.length < 2) {
    return null;
  }
  for (const [key, usual] of [["a", known.at(-2)], ["b", known.at(-1)]]) {
    pair[key] = known.some((node) => node.id === pair[key]) ? pair[key] : usual.id;
  }
  const body = h("tbody"), note = h("p", { class: "quiet" });
  const show = () => {
    const [a, b] = [pair.a, pair.b].map((id) => known.find((node) => node.id === id));
    note.textContent = a.on.join() === b.on.join() ? "" : "They were judged on different recordings.";
    const row = (name, before, after) => h("tr", {}, h("td", {}, name), h("td", { class: "number" }, number(before)),
      h("td", { class: "number" }, number(after)), h("td", { class: "number" }, before ? `${(100 * (after / before - 1)).toFixed(1)} %` : "–"));
    body.replaceChildren(...a.compared.joint_names.map((name) => row(name, a.compared.joints[name].rmse, b.compared.joints[name]?.rmse)),
      row("all", a.compared.rmse, b.compared.rmse));
  };
  const pick = (key, label) => h("select", { class: "pick", "data-key": "pair" + key, "aria-label": label,
    onchange: (event) => {
      pair[key] = event.target.value;
      show();
    } }, known.map((node, k) => h("option", { value: node.id, selected: node.id === pair[key] }, `${k + 1}: ${node.title}`)));
  show();
  return h("section", { class: "card" }, h("h3", {}, "Two models"), h("div", { class: "stack" }, pick("a", "first model"), pick("b", "second model")), note, h("p", { class: "quiet" }, "Unseen error of each, N·m."),
    h("table", { class: "close" }, h("thead", {}, h("tr", {}, h("th", {}, "joint"), ["first", "second", "change"].map((text) => h("th", { class: "number" }, text)))), body));
}

export function view(state, { go }) {
  const node = current(state);
  if (!node) {
    return [head("Steps", "Each effect that is added is a step; the error on unseen motion shows what it was worth."),
      h("div", { class: "empty" }, h("h3", {}, "No model yet"), "Learn one first.")];
  }
  const steps = line(state).filter((one) => one.compared);
  const joints = node.described.joints;
  const busy = state.work.length > 0, figure = stairs(state, 640, 240);
  return [
    head("Steps", busy ? state.work[0].title + "…" : "The error on motion that no model learned from, after each step.",
      h("button", { class: "plain", "data-key": "undo", disabled: !node.parent, onclick: () => ask("undo") }, "Undo"),
      h("button", { class: "plain", "data-key": "redo", disabled: !state.undone.length, onclick: () => ask("redo") }, "Redo"),
      h("button", { class: "main", "data-key": "next", onclick: () => go("diagnose") }, "Look for more"),
      h("button", { class: "plain", "data-key": "take", onclick: () => go("take") }, "Take it away")),
    h("div", { class: "two" },
      h("section", { class: "card drawn" }, figure, figure ? saver(figure, "steps") : null,
        h("table", {}, h("thead", {}, h("tr", {}, h("th", {}, "step"), joints.map((name) => h("th", { class: "number" }, name)), h("th", { class: "number" }, "all [N·m]"), h("th", {}, "evidence"))),
          h("tbody", {}, steps.map((one) => h("tr", {}, h("td", {}, one.title),
            joints.map((name) => h("td", { class: "number" }, number(one.compared.joints[name]?.rmse))),
            h("td", { class: "number total" }, number(one.compared.rmse)),
            h("td", { class: "quiet" }, evidence(one))))))),
      h("div", {}, h("section", { class: "card" }, h("h3", {}, "All models"), h("p", { class: "quiet" }, "Choose one to go on from it."), branch(state, "", true)), versus(state))),
  ];
}
