// Effects switched on and off: the unseen error of each combination at once.
import { h, number } from "./dom.js";
import { ask } from "./link.js";

const ticked = new Map();

export function whatIf(node, busy) {
  const sound = node.diagnosed.findings.filter((one) => !one.once);
  if (!sound.length) {
    return null;
  }
  const frame = (...inside) => h("section", { class: "card" }, h("h3", {}, "What if"), inside);
  if (!node.what_if) {
    return frame(h("p", { class: "quiet" }, "Each of these effects alone and together, judged on motion that took no part."),
      h("button", { class: "plain", "data-key": "whatif", disabled: busy, onclick: () => ask("whatif") }, "Try all combinations"));
  }
  const { names, combinations } = node.what_if;
  const on = ticked.get(node.id) || new Set();
  ticked.set(node.id, on);
  const none = combinations.find((one) => !one.with.length).rmse;
  const result = h("p", { "aria-live": "polite" });
  const table = h("tbody");
  const show = () => {
    const found = combinations.find((one) => one.with.length === on.size && one.with.every((k) => on.has(k)));
    result.textContent = found.rmse === null ? "These exclude each other."
      : `Unseen error ${number(found.rmse)} N·m` + (on.size ? `, ${number(100 * (found.rmse / none - 1))} % against none of them.` : " without any of them.");
    const best = Math.max(...combinations.map((one) => one.rmse ?? 0));
    table.replaceChildren(...[...combinations].sort((a, b) => (a.rmse ?? Infinity) - (b.rmse ?? Infinity)).slice(0, 8).map((one) =>
      h("tr", {}, h("td", {}, one.with.map((k) => names[k]).join(" + ") || "none of them"),
        h("td", { class: "number" }, number(one.rmse)),
        h("td", {}, h("meter", { min: 0, max: best, value: one.rmse ?? 0, "aria-label": "error" })))));
  };
  const boxes = names.map((name, k) => h("label", { class: "tick" },
    h("input", { type: "checkbox", "data-key": "tick" + k, checked: on.has(k), onchange: (event) => {
      if (event.target.checked) {
        on.add(k);
      } else {
        on.delete(k);
      }
      show();
    } }), " ", name));
  show();
  return frame(h("div", { class: "row" }, boxes), result,
    h("table", {}, h("thead", {}, h("tr", {}, h("th", {}, "with"), h("th", { class: "number" }, "unseen error [N·m]"), h("th", {}, h("span", { class: "quiet" }, "beside each other")))), table));
}
