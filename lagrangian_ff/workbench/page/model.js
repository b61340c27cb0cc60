// The model: what it is, and how it errs on motion that it has not seen.
import { h, head, number, spoken } from "./dom.js";
import { ask, current } from "./link.js";
import { checksOfFiles, notices } from "./checks.js";

export const TITLE = "Model";

export function status(state) {
  const node = current(state);
  return node ? node.described.name : "not learned yet";
}

export function errors(compared) {
  const joints = compared.joint_names;
  return h("table", {}, h("thead", {}, h("tr", {}, h("th", {}, "joint"), h("th", { class: "number" }, "error [N·m]"),
    h("th", { class: "number" }, "of the torque's spread"))),
    h("tbody", {}, joints.map((name) => h("tr", {}, h("td", {}, name),
      h("td", { class: "number" }, number(compared.joints[name].rmse)),
      h("td", { class: "number" }, compared.joints[name].nmse === null ? "–" : number(100 * Math.sqrt(compared.joints[name].nmse)) + " %")))));
}

function effects(described) {
  const rows = described.effects.flatMap((one) => Object.entries(one.parameters).map(([name, value], k) =>
    h("tr", {}, h("td", {}, k ? "" : one.joint), h("td", {}, k ? "" : spoken(one.effect)), h("td", { class: "formula" }, name),
      h("td", { class: "number" }, number(value.value)),
      h("td", { class: "number quiet" }, value.low === null ? "" : `${number(value.low)} to ${number(value.high)}`),
      h("td", { class: "quiet" }, value.unit))));
  return rows.length ? h("table", {}, h("thead", {}, h("tr", {}, ["joint", "effect", "", "value", "90 % interval", "unit"].map((text, k) =>
    h("th", { class: k === 3 || k === 4 ? "number" : "" }, text || h("span", { class: "quiet" }, "name"))))), h("tbody", {}, rows)) : null;
}

// Which model is learned next, with what it assumes.
function choice(state) {
  const chosen = state.choices.find((one) => one.name === state.choice) || state.choices[0];
  return [h("select", { class: "pick", "data-key": "choice", "aria-label": "model to learn", "aria-describedby": "meaning",
    onchange: (event) => ask("choose", { model: event.target.value }) },
    state.choices.map((one) => h("option", { value: one.name, selected: one === chosen }, one.title))),
    h("p", { class: "quiet meaning", id: "meaning" }, chosen.meaning)];
}

export function view(state, { go }) {
  const node = current(state);
  const learn = h("button", { class: node ? "plain" : "main", "data-key": "learn", disabled: state.work.length > 0,
    onclick: () => ask("learn") }, node ? "Learn again" : "Learn a model");
  const [select, meaning] = choice(state);
  if (!node) {
    return [head("Model", "Rigid-body dynamics and friction are learned from the recordings alone.", select, learn, meaning),
      h("div", { class: "empty" }, h("h3", {}, state.work.length ? "A model is being learned" : "No model yet"),
        state.work.length ? "It is here when the bar above is full." : "Learn one from the recordings under Learn from.")];
  }
  const next = h("button", { class: "main", "data-key": "next", onclick: () => go("compare") }, "See where it fails");
  const compared = node.compared;
  return [head("Model", `${node.described.name}, ${node.title}, in ${number(node.described.seconds)} s`, select, learn, next, meaning),
    ...notices(state), ...checksOfFiles(state, (compared && compared.checks) || [], node.on),
    h("div", { class: "two" },
      h("section", { class: "card" }, h("h3", {}, "Friction and other effects"), effects(node.described) || h("p", { class: "quiet" }, "None beside the dynamics.")),
      h("section", { class: "card" }, h("h3", {}, "Error on unseen motion"),
        compared ? errors(compared) : h("p", { class: "quiet" }, "It is being compared…"),
        compared && compared.warning ? h("p", { class: "quiet" }, compared.warning + ".") : null)),
    node.described.notes.length ? h("details", {}, h("summary", {}, "Remarks"), h("ul", {}, node.described.notes.map((note) => h("li", {}, note)))) : null].filter(Boolean);
}
