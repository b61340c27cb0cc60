// Which effects a recording could show, before a model is learned.
import { h, number, spoken } from "./dom.js";
import { ask } from "./link.js";

const opened = new Set();
const STEPS = [0.02, 0.05, 0.1];

function percent(share) {
  return share === null || share >= 1 ? "–" : share < 0.01 ? "<1" : String(Math.round(100 * share));
}

function level(share) {
  const place = STEPS.findIndex((step) => share !== null && share <= step);
  return place < 0 ? 0 : STEPS.length - place;
}

function cell(effect, joint, share) {
  const text = percent(share);
  const words = text === "–" ? `not seen on ${joint}` : `seen on ${joint} from ${text} % of its torque`;
  return h("td", { class: "level" + level(share), title: `${spoken(effect)}: ${words}` }, text);
}

function table(found) {
  const least = Object.entries(found.least).map(([effect, row]) => [effect, found.joints.map((joint) => row[joint])]);
  const worst = (row) => Math.max(...row.map((share) => share ?? Infinity));
  least.sort((a, b) => worst(a[1]) - worst(b[1]));
  return h("div", { class: "wide", tabindex: "0", role: "region", "aria-label": "least size of each effect on each joint" }, h("table", { class: "seen" },
    h("caption", {}, "Least size, in per cent of the joint's torque, from which on the search expects to see an effect; – is never."),
    h("thead", {}, h("tr", {}, h("th", { scope: "col" }, "effect"), found.joints.map((joint) => h("th", { scope: "col" }, h("span", {}, joint))))),
    h("tbody", {}, least.map(([effect, row]) => h("tr", {}, h("th", { scope: "row" }, spoken(effect)), row.map((share, n) => cell(effect, found.joints[n], share)))))));
}

// The motion to do, for each effect that is hidden on some joint.
function motions(found) {
  const groups = new Map();
  for (const one of found.not_observable.filter((other) => other.joint !== "all")) {
    const known = groups.get(one.effect) || { joints: [], motion: one.next_motion };
    known.joints.push(one.joint);
    groups.set(one.effect, known);
  }
  const whose = (joints) => (joints.length === found.joints.length ? "every joint" : joints.join(", "));
  return groups.size ? [h("p", { class: "quiet others" }, "The motion to do for the others:"), h("ul", {}, [...groups].map(([effect, { joints, motion }]) =>
    h("li", {}, `${spoken(effect)} (${whose(joints)}): ${motion}`)))] : null;
}

function summary(found) {
  const rows = Object.values(found.least).map((row) => found.joints.filter((joint) => row[joint] !== null && row[joint] <= found.size).length);
  const whole = rows.filter((count) => count === found.joints.length).length, none = rows.filter((count) => !count).length;
  const some = rows.length - whole - none;
  return `At ${number(100 * found.size)} % of the torque it shows ${whole} of ${rows.length} effects` + (some ? `, ${some} more on some joints` : "") + (none ? `, ${none} on none` : "");
}

export function observed(card) {
  if (card.observed) {
    return h("details", { class: "observed", open: opened.has(card.id), ontoggle: (event) => (event.target.open ? opened.add(card.id) : opened.delete(card.id)) },
      h("summary", { "data-key": "observed" + card.id }, summary(card.observed)), table(card.observed), motions(card.observed));
  }
  const [words, what, label] = card.unobserved
    ? [`Which effects it could show is not known: ${card.unobserved}.`, "observe", "Find out"]
    : ["Finding out which effects it could show…", "skip", "Cancel"];
  return h("div", { class: "check short" }, h("p", { class: "quiet" }, words),
    h("button", { class: "save", "data-key": what + card.id, "aria-label": `${label}: which effects ${card.name} could show`, onclick: () => ask(what, { card: card.id }) }, label));
}
