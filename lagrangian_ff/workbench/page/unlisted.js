// Torques that no effect of the catalogue fits: taken in as curves, and formulas proposed for them.
import { h, number, spoken } from "./dom.js";
import { ask } from "./link.js";
import { blocks, curve } from "./figures.js";
import { saver } from "./save.js";

function percent(share) {
  return `${number(100 * share)} %`;
}

// A pure number has none.
function unit(text) {
  return text === "1" ? "" : text;
}

function proposer(joint, node, busy) {
  return h("button", { class: "plain", disabled: busy, "data-key": "propose" + joint, onclick: () => ask("propose", { joint }) },
    node.proposed[joint] ? "Propose again" : "Propose formulas");
}

function drawn(figures, name) {
  return h("div", {}, figures.filter(Boolean).map((figure, k) => h("div", { class: "drawn" }, figure, saver(figure, name + (k ? "_blocks" : "")))));
}

// Something over a coordinate without a name.
function left(one, node, busy, go) {
  const sure = node.diagnosed.findings.some((found) => found.verdict === "confirmed");
  const figures = [one.curve && curve(one), one.blocks && blocks(one)];
  return h("article", { class: "card finding" }, h("div", {},
    h("h3", {}, `Unexplained on ${one.joint} `), h("span", { class: "badge suggested" }, "no effect fits"),
    h("p", {}, `Something ${percent(one.share)} the size of its torque depends on ${one.coordinate}, and no effect of the catalogue looks so.`),
    one.before === null ? null : h("p", {}, `As a curve${sure ? ", beside what is confirmed above" : ""}: unseen error of the joint ${number(one.before)} → ${number(one.after)} N·m` + (one.worth ? "." : ", which is not worth it.")),
    h("p", { class: "quiet" }, `log Bayes factor ${number(one.gain)}. A curve is splines; it has no name, and is zero outside what was seen.`),
    h("div", { class: "row" }, one.form ? h("button", { class: one.worth ? "main" : "plain", disabled: busy, "data-key": "curve" + one.effect + one.joint, onclick: async () => {
      if (await ask("curve", { effect: one.effect, joint: one.joint })) {
        go("history");
      }
    } }, "Take the curve in") : null, proposer(one.joint, node, busy))),
  drawn(figures, `curve_${one.joint}`));
}

function formula(one, busy, go) {
  // Over another coordinate than its own a formula cannot be recognised.
  const over = one.effect.endsWith(`_${one.curve.coordinate}`) ? curve(one) : null;
  return h("article", { class: "card finding" }, h("div", {},
    h("h3", {}, `A formula for ${one.joint} `), h("span", { class: "badge " + one.verdict }, one.said),
    h("p", { class: "formula" }, "τ = " + one.formula),
    h("p", {}, one.meaning[0].toUpperCase() + one.meaning.slice(1) + "."),
    one.before === null || one.after === null ? null : h("p", {}, `Unseen error of the joint: ${number(one.before)} → ${number(one.after)} N·m.`),
    h("ul", { class: "quiet" }, Object.entries(one.parameters).map(([name, value]) =>
      h("li", {}, `${name} = ${number(value.value)} ${unit(value.unit)}` + (value.low === null ? "" : ` (${number(value.low)} to ${number(value.high)})`))),
    Object.entries(one.shape).map(([name, value]) => h("li", {}, `${name} = ${number(value)} ${unit(one.file.units[name])}`))),
    h("p", { class: "quiet" }, `log Bayes factor ${number(one.gain)}` + (one.p_value === null ? "." : `; chance gives as much once in ${number(1 / Math.max(one.p_value, 1e-6))} searches.`)),
    one.doubt ? h("p", { class: "quiet" }, `Only suggested: ${one.doubt}.`) : null,
    one.rivals.length ? h("p", { class: "quiet" }, `As good on this motion: ${one.rivals.map(spoken).join(", ")}.`) : null,
    h("div", { class: "row" }, h("button", { class: one.verdict === "confirmed" ? "main" : "plain", disabled: busy, "data-key": "take" + one.effect + one.joint,
      onclick: async () => {
        if (await ask("take", { effect: one.effect, joint: one.joint })) {
          go("history");
        }
      } }, "Add"))),
  drawn([over, one.blocks && blocks(one)], one.effect));
}

function proposed(found, busy, go) {
  const beside = found.curve_error === null ? "" : ` With the curve that the model has there the error is ${number(found.curve_error)} N·m; a formula takes its place.`;
  return [h("section", { class: "lead" }, h("h3", {}, `Formulas for ${found.joint}`),
    h("p", { class: "quiet" }, `${found.tried} formulas and curves competed; of so many, chance gives the best ${number(found.threshold)} nats once in twenty times. The best curve gains ${number(found.curve_gain)} nats.${beside} A formula says how a torque looks, not what causes it.`)),
  ...found.formulas.map((one) => formula(one, busy, go)),
  found.formulas.length ? null : h("p", {}, "No formula fits.")].filter(Boolean);
}

// Joints on which something is left, or held as a curve, and for which formulas may be proposed.
function others(node, named) {
  const { remainders = [] } = node.diagnosed || {};
  const curves = node.described.effects.filter((one) => one.effect.startsWith("curve")).map((one) => [one.joint, "the model holds a curve there"]);
  const rest = remainders.map((one) => [one.joint, `${number(one.size)} N·m more than noise is left, ${percent(one.share)} of its torque`]);
  const found = new Map();
  [...curves, ...rest].filter(([joint]) => !named.has(joint)).forEach(([joint, words]) => found.set(joint, [...(found.get(joint) || []), words]));
  return [...found];
}

export function unlisted(node, busy, go) {
  const { unexplained = [] } = node.diagnosed || {};
  const rest = others(node, new Set(unexplained.map((one) => one.joint)));
  return [...unexplained.map((one) => left(one, node, busy, go)),
    rest.length ? h("section", { class: "card" }, h("h3", {}, "What nobody listed"), h("ul", { class: "own" }, rest.map(([joint, words]) =>
      h("li", { class: "row" }, h("span", {}, `${joint}: ${words.join("; ")}.`), proposer(joint, node, busy))))) : null,
    ...Object.values(node.proposed).flatMap((found) => proposed(found, busy, go))].filter(Boolean);
}
