// The dialog before an arm moves: what would happen, and two buttons, of which the harmless one has the focus.
import { h } from "./dom.js";

export function angle(value) {
  return value.toFixed(3).replace(/^-(0\.0+)$/, "$1");
}

export function names(list) {
  return list.length ? list.join(", ") : "none";
}

// rows: [term, words]; header and joints: of the table; notes: sentences; no, yes: {words, act}. Escape does neither.
export function confirm({ title, rows, header, joints, notes, no, yes }) {
  const before = document.activeElement?.dataset.key;
  const move = h("button", { class: "main danger", onclick: () => {
    dialog.close(); // first: behind it, the button that stops the arm could not take the focus
    yes.act();
  } }, yes.words);
  const stay = h("button", { class: "plain", autofocus: true, onclick: () => {
    no.act?.();
    dialog.close();
  } }, no.words);
  const dialog = h("dialog", { "aria-labelledby": "confirm-title", "aria-describedby": "confirm-care" },
    h("h2", { id: "confirm-title" }, title),
    h("dl", {}, rows.map(([term, words]) => [h("dt", {}, term), h("dd", {}, words)])),
    h("table", {}, h("thead", {}, h("tr", {}, header.map((text, k) => h("th", { class: k ? "number" : "" }, text)))),
      h("tbody", {}, joints.map((cells) => h("tr", {}, cells.map((text, k) => h("td", { class: k ? "number" : "" }, text)))))),
    notes.map((note) => h("p", { class: "quiet" }, note)),
    h("p", { id: "confirm-care" }, "Have the emergency stop at hand. This page is no safety function: the controller's own limits hold."),
    h("div", { class: "row" }, stay, move));
  dialog.addEventListener("close", () => {
    dialog.remove();
    if (before && document.activeElement === document.body) {
      document.querySelector(`[data-key="${CSS.escape(before)}"]`)?.focus();
    }
  });
  document.body.append(dialog);
  dialog.showModal();
  return dialog;
}
