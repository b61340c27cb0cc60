// The motion to record next: what it shows, its picture, and its file.
import { h, number, s } from "./dom.js";
import { ask } from "./link.js";
import { ticks } from "./figures.js";

export function mover(effect, joint, busy, label) {
  return h("button", { class: "plain", disabled: busy, "data-key": `move${effect}${joint}`,
    onclick: () => ask("move", { effect, joint }) }, label);
}

// Positions of the joints that move, one lane each.
export function picture(motion) {
  const moving = motion.joints.map((name, n) => ({ name, q: motion.q[n] }))
    .map((one) => ({ ...one, low: Math.min(...one.q), high: Math.max(...one.q) })).filter((one) => one.high - one.low > 1e-3);
  const width = 560, lane = 46, left = 86, right = 64, height = moving.length * lane + 22;
  const end = motion.time.at(-1), x = (at) => left + (at / end) * (width - left - right);
  return s("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `positions over ${number(motion.seconds)} s of ${moving.map((one) => one.name).join(", ")}` },
    moving.map((one, k) => {
      const y = (value) => k * lane + 6 + (lane - 12) * (1 - (value - one.low) / (one.high - one.low));
      return [s("text", { x: 0, y: k * lane + lane / 2 + 4 }, one.name),
        s("text", { x: width - right + 8, y: k * lane + 14 }, number(one.high)),
        s("text", { x: width - right + 8, y: k * lane + lane - 5 }, number(one.low)),
        s("path", { class: "effect", d: one.q.map((value, j) => `${j ? "L" : "M"}${x(motion.time[j]).toFixed(1)} ${y(value).toFixed(1)}`).join("") })];
    }),
    ticks(0, end).map((at) => s("text", { x: x(at), y: height - 4, "text-anchor": "middle" }, `${at} s`)),
    s("text", { x: width, y: height - 4, "text-anchor": "end" }, "rad"));
}

export function motions(state) {
  return [...state.motions].reverse().slice(0, 3).map((one) =>
    h("section", { class: "card finding" },
      h("div", {}, h("h3", {}, `The next motion: ${one.title}`),
        h("p", {}, one.meaning[0].toUpperCase() + one.meaning.slice(1) + (one.meaning.endsWith(".") ? "" : ".")),
        h("p", { class: "quiet" }, one.by_hand),
        h("p", { class: "quiet" }, `${number(one.seconds)} s, within the positions, speeds and accelerations that the model has seen. Bring the arm to its start first, and make sure that the way is clear.`),
        h("p", {}, h("a", { class: "plain", href: `api/motion/${one.id}`, download: "motion.csv", "data-key": "save" + one.id }, "Save the motion"))),
      h("div", { class: "drawn" }, picture(one))));
}
