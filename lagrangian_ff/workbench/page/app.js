// The frame: steps on the left, the chosen one beside them, work under way above.
import { h } from "./dom.js";
import { ask, follow, open, say } from "./link.js";
import { stairs } from "./figures.js";
import * as data from "./data.js";
import * as live from "./live.js";
import * as model from "./model.js";
import * as compare from "./compare.js";
import * as diagnose from "./diagnose.js";
import * as investigate from "./investigate.js";
import * as history from "./history.js";
import * as take from "./take.js";

const STEPS = { data, live, model, compare, diagnose, investigate, history, take };
let shown = "";
let drawn = "", told = "";

function steps(state) {
  return Object.entries(STEPS).filter(([, step]) => !step.listed || step.listed(state));
}

function chosen(state) {
  const name = location.hash.slice(1);
  return steps(state).some(([one]) => one === name) ? name : "data";
}

function drawSteps(state) {
  const names = steps(state).map(([name, step]) =>
    h("button", { "aria-current": name === chosen(state) ? "step" : null, onclick: () => go(name) },
      step.TITLE, h("small", {}, step.status(state))));
  const focused = [...document.querySelectorAll("#steps button")].indexOf(document.activeElement);
  const figure = stairs(state, 170, 90);
  const place = document.getElementById("steps");
  place.replaceChildren(...names, ...(figure ? [h("div", { class: "stairs" }, figure)] : []));
  if (focused >= 0) {
    place.querySelectorAll("button")[focused]?.focus();
  }
}

function drawWork(state) {
  const place = document.getElementById("work");
  const work = state.work[0];
  if (!work) {
    if (place.childElementCount) {
      place.replaceChildren();
    }
    return;
  }
  const more = state.work.length > 1 ? `, ${state.work.length - 1} more` : "";
  const stops = work.stops && !state.arm.halted;
  if (place.dataset.work !== work.id + stops || !place.childElementCount) {
    place.dataset.work = work.id + stops;
    place.replaceChildren(
      h("span", {}), h("progress", { max: 1, "aria-label": work.title }),
      stops ? h("button", { class: "main danger", "data-key": "halt", onclick: () => ask("halt") }, "Stop the arm")
        : h("button", { class: "plain", onclick: () => ask("cancel", { work: work.id }) }, "Cancel"));
  }
  const text = `${work.title} – ${work.label}${more}`;
  if (place.firstChild.textContent !== text) {
    place.firstChild.textContent = text;
  }
  place.querySelector("progress").value = work.share;
}

export function go(name) {
  location.hash = name;
}

function draw(state) {
  drawWork(state);
  live.banner(state);
  investigate.banner(state);
  document.getElementById("top").classList.toggle("moving", Boolean(state.live?.motion || state.arm.running));
  const key = [chosen(state), state.version, state.work.length > 0, state.arm.asks, state.live?.topics].join();
  const statuses = key + steps(state).map(([, step]) => step.status(state)).join();
  if (statuses !== told) {
    told = statuses;
    drawSteps(state);
  }
  if (key === drawn) {
    return;
  }
  const place = document.getElementById("view");
  // What is being dragged stays until it is let go.
  if (place.querySelector("canvas:active")) {
    return;
  }
  drawn = key;
  const fresh = shown !== chosen(state);
  shown = chosen(state);
  const id = place.contains(document.activeElement) ? document.activeElement.dataset.key : null;
  place.replaceChildren(...STEPS[shown].view(state, { go }));
  document.title = `${STEPS[shown].TITLE} – Workbench`;
  if (fresh) {
    window.scrollTo(0, 0);
  }
  if (id) {
    place.querySelector(`[data-key="${CSS.escape(id)}"]`)?.focus();
  }
  const said = document.getElementById("said");
  if (state.said && said.dataset.told !== state.said) {
    said.dataset.told = state.said;
    say(state.said);
  }
}

let latest = null;
follow((state) => {
  latest = state;
  draw(state);
});
window.addEventListener("pointerup", () => setTimeout(() => latest && draw(latest)));
window.addEventListener("hashchange", () => {
  if (latest) {
    draw(latest);
    document.getElementById("view").focus({ preventScroll: true });
  }
});
open();
