// What is wrong with a measurement, and a button for each remedy that is a setting of reading.
import { h, number } from "./dom.js";
import { ask } from "./link.js";

const EFFORTS = { total: "all torque", "without-gravity": "torque without gravity", "without-friction": "torque without friction" };

function same(a, b) {
  return a && b && a.effort === b.effort && a.delay === b.delay && JSON.stringify(a.scale) === JSON.stringify(b.scale);
}

function remedy(check, cards, key) {
  return check.remedy && cards.length ? h("button", { class: "plain", "data-key": key, onclick: () =>
    ask("read", { cards: cards.map((card) => card.id), scale: check.remedy.scale, effort: check.remedy.effort, delay: check.remedy.delay }) }, check.remedy.words) : null;
}

function sentence(text) {
  const first = /^[a-z]+\b(?!_)/.test(text) ? text[0].toUpperCase() + text.slice(1) : text;
  return /[.?!]$/.test(first) ? first : first + ".";
}

// An advice, whose options of the command line are not broken.
function advised(text) {
  return sentence(text).split(/(--[\w-]+)/).map((part) => (part.startsWith("--") ? h("span", { class: "option" }, part) : part));
}

function lines(checks, cardsOf, key, first) {
  return checks.map((one, k) => h("div", { class: "check" },
    h("p", {}, one.serious && first ? h("b", { class: "bad" }, first) : null, sentence(one.finding), one.advice ? h("span", { class: "quiet" }, " ", advised(one.advice)) : null),
    remedy(one, cardsOf(one), key + k)));
}

// Of a recording: the remedy is for all that show the same.
export function checksOfCard(state, card) {
  const alike = (check) => state.cards.filter((one) => one.looked && (one.looked.checks || []).some((other) => same(other.remedy, check.remedy)));
  return lines(card.looked.checks || [], alike, "remedy" + card.id, "Mend first: ");
}

// Of a model on some files: these are read in another way.
export function checksOfFiles(state, checks, files) {
  const cards = state.cards.filter((card) => files.includes(card.file));
  const serious = checks.filter((one) => one.serious), others = checks.filter((one) => !one.serious);
  return [
    serious.length ? h("section", { class: "card" }, h("h3", { class: "bad" }, "Look at this first"), lines(serious, () => cards, "remedy", "")) : null,
    others.length ? h("details", {}, h("summary", {}, `${others.length} remark${others.length > 1 ? "s" : ""} about the measurement`), lines(others, () => cards, "remark", "")) : null];
}

// How a recording's effort is read, where that is not the usual; all that are read so go back together.
export function readAs(state, card) {
  const scales = Object.entries(card.scale).filter(([, factor]) => factor !== 1);
  if (!scales.length) {
    return null;
  }
  const words = scales.map(([joint, factor]) => (factor === -1 ? `${joint} with the sign turned round` : `${joint} times ${number(factor)}`)).join(", ");
  const alike = state.cards.filter((one) => JSON.stringify(one.scale) === JSON.stringify(card.scale));
  return h("div", { class: "check short" }, h("p", {}, `Effort of ${words}.`),
    back("back" + card.id, { cards: alike.map((one) => one.id) }));
}

function notice(words, button) {
  return h("div", { class: "row notice" }, h("span", {}, words), button);
}

function back(key, asked) {
  return h("button", { class: "plain", "data-key": key, onclick: () => ask("read", { scale: {}, ...asked }) }, "Take it back");
}

// What holds for the whole session: how all effort is read, and models that were learned otherwise.
export function notices(state, learn) {
  const found = [];
  if (state.effort !== "total") {
    found.push(notice(`The effort of all recordings is read as ${EFFORTS[state.effort]}.`, back("backeffort", { effort: "total" })));
  }
  if (state.effort_delay) {
    const late = state.effort_delay > 0, [what, other] = late ? ["effort", "position"] : ["position", "effort"];
    const by = number(1e3 * Math.abs(state.effort_delay));
    found.push(notice(`The ${what} of all recordings is read as ${by} ms later than the ${other}.`, back("backdelay", { delay: 0 })));
  }
  if (state.outdated.includes(state.current)) {
    found.push(notice("The model was learned before the settings of reading changed: it knows the recordings as they were.",
      learn ? h("button", { class: "plain", "data-key": "learnagain", disabled: state.work.length > 0, onclick: learn }, "Learn again") : null));
  }
  return found;
}
