// An effect of one's own, written as a formula.
import { h } from "./dom.js";
import { ask } from "./link.js";

const typed = { name: "", formula: "", shapes: "" };

// "w: 0.05 to 1, p: 1 to 3" as {w: [0.05, 1], p: [1, 3]}.
function ranges(text) {
  const found = {};
  for (const part of text.split(",").filter((one) => one.trim())) {
    const match = part.match(/^\s*(\w+)\s*:\s*([\d.eE+-]+)\s*(?:to|-|–)\s*([\d.eE+-]+)\s*$/);
    if (!match) {
      return null;
    }
    found[match[1]] = [Number(match[2]), Number(match[3])];
  }
  return found;
}

export function formulas(state, node, busy, go) {
  const field = (key, label, example) => h("label", { class: "field" }, label,
    h("input", { "data-key": "formula" + key, value: typed[key], placeholder: example, spellcheck: "false",
      oninput: (event) => { typed[key] = event.target.value; } }));
  const wrong = h("p", { class: "bad", role: "alert" });
  const take = h("button", { class: "plain", "data-key": "takeformula", onclick: async () => {
    const shapes = ranges(typed.shapes);
    wrong.textContent = shapes ? "" : "Write ranges as w: 0.05 to 1";
    if (shapes && (await ask("formula", { name: typed.name, formula: typed.formula, shapes }))) {
      Object.assign(typed, { name: "", formula: "", shapes: "" });
    }
  } }, "Take it into the search");
  const own = state.formulas.map((one) => {
    const joint = h("select", { class: "pick", "data-key": "joint" + one.name, "aria-label": `joint of ${one.name}` },
      node.described.joints.map((name) => h("option", { value: name }, name)));
    return h("li", { class: "row" }, h("span", {}, `${one.name}: `, h("span", { class: "formula" }, one.formula)), joint,
      h("button", { class: "plain", "data-key": "own" + one.name, disabled: busy, onclick: async () => {
        if (await ask("add", { effect: one.name, joint: joint.value })) {
          go("history");
        }
      } }, "Add it"));
  });
  return h("section", { class: "card" }, h("h3", {}, "An effect of your own"),
    h("p", { class: "quiet" }, "A sum of terms, each with a parameter as a factor. Inputs: q, qd, qdd, load. Functions: sin, cos, tan, tanh, atan, exp, log, sqrt, abs, sign. Numbers that are no factor need a range, in which they are searched."),
    h("div", { class: "fields" }, field("name", "Name", "my_bump"), field("formula", "Torque", "A*exp(-(q/w)^2)"), field("shapes", "Ranges", "w: 0.05 to 1"), take),
    wrong, own.length ? h("ul", { class: "own" }, own) : null);
}
