// What is missing, with the evidence for it.
import { h, head, number, spoken } from "./dom.js";
import { ask, current } from "./link.js";
import { blocks, curve } from "./figures.js";
import { checksOfFiles, notices } from "./checks.js";
import { saver } from "./save.js";
import { formulas } from "./formula.js";
import { whatIf } from "./whatif.js";
import { motions, mover } from "./motion.js";
import { unlisted } from "./unlisted.js";

export const TITLE = "Diagnose";

export function status(state) {
  const node = current(state);
  if (!node || !node.diagnosed) {
    return "what is missing?";
  }
  const sure = node.diagnosed.findings.filter((one) => one.verdict === "confirmed").length;
  return sure ? `${sure} confirmed` : "nothing confirmed";
}

function card(found, busy, go) {
  const fall = found.before && found.after !== null ? 1 - found.after / found.before : null;
  const gain = `log Bayes factor ${number(found.gain)}` +
    (found.p_value === null ? "" : `; chance gives as much once in ${number(1 / Math.max(found.p_value, 1e-6))} searches`);
  return h("article", { class: "card finding" },
    h("div", {},
      h("h3", {}, `${spoken(found.effect)} on ${found.place} `), h("span", { class: "badge " + found.verdict }, found.said),
      h("p", {}, found.meaning[0].toUpperCase() + found.meaning.slice(1) + "."),
      h("p", { class: "formula" }, "τ = " + found.formula),
      fall === null ? null : h("p", {}, `Unseen error of ${found.error_of}: ${number(found.before)} → ${number(found.after)} N·m, ${Math.abs(Math.round(100 * fall))} % ${fall >= 0 ? "lower" : "higher"}.`),
      h("p", { class: "quiet" }, gain + "."),
      h("ul", { class: "quiet" }, Object.entries(found.parameters).map(([name, value]) =>
        h("li", {}, `${name} = ${number(value.value)} ${value.unit}` + (value.low === null ? "" : ` (${number(value.low)} to ${number(value.high)})`)))),
      found.doubt ? h("p", { class: "quiet" }, `Only suggested: ${found.doubt}.`) : null,
      found.told_apart_by.map((text) => h("p", { class: "quiet" }, "Told apart by: " + text)),
      h("div", { class: "row" }, found.once ? null : h("button", { class: found.verdict === "confirmed" ? "main" : "plain", disabled: busy,
        "data-key": "add" + found.effect + found.joint, onclick: async () => {
          if (await ask("add", { effect: found.effect, joint: found.joint })) {
            go("history");
          }
        } }, "Add it"),
        found.verdict === "confirmed" ? null : mover(found.effect, found.joint, busy, "Make the motion that decides"))),
    drawn(found));
}

function drawn(found) {
  const name = `${found.effect}_${found.joint}`, over = curve(found), fall = found.blocks ? blocks(found) : null;
  return h("div", {}, h("div", { class: "drawn" }, over, saver(over, name)),
    fall ? h("div", { class: "drawn" }, fall, saver(fall, name + "_blocks")) : null);
}

export function view(state, { go }) {
  const node = current(state);
  const busy = state.work.length > 0;
  const start = h("button", { class: node && node.diagnosed ? "plain" : "main", disabled: !node || busy, "data-key": "start",
    onclick: () => ask("diagnose") }, node && node.diagnosed ? "Look again" : "Find what is missing");
  if (!node || !node.diagnosed) {
    return [head("What is missing?", "Every known effect is tried on every joint. Only what also helps on motion that was not searched is confirmed.", start),
      h("div", { class: "empty" }, h("h3", {}, !node ? "No model yet" : busy ? "Looking" : "Not looked yet"),
        !node ? "Learn a model first." : busy ? "This takes some seconds to a minute." : "It takes some seconds to a minute."),
      ...(node ? [...unlisted(node, busy, go), formulas(state, node, busy, go)] : [])];
  }
  const found = node.diagnosed;
  return [head("What is missing?", found.verdict, start),
    ...notices(state), ...checksOfFiles(state, found.checks, found.on || []),
    ...found.findings.map((one) => card(one, busy, go)),
    ...unlisted(node, busy, go),
    ...motions(state),
    whatIf(node, busy),
    found.findings.length || (found.unexplained || []).length ? null : h("div", { class: "empty" }, h("h3", {}, "Nothing is missing that these recordings can show"),
      "The list below says what they could not show."),
    found.not_observable.length ? h("details", {}, h("summary", {}, `${found.not_observable.length} effects that this motion cannot show`),
      h("ul", { class: "hidden-effects" }, found.not_observable.map((one) => h("li", {}, h("span", {}, `${spoken(one.effect)} on ${one.joint}: ${one.reason}; ${one.motion}`),
        mover(one.effect, one.joint === "all" ? "" : one.joint, busy, "Make this motion"))))) : null,
    formulas(state, node, busy, go)].filter(Boolean);
}
