// Recordings: what each holds, and what it is for.
import { h, head, number } from "./dom.js";
import { ask, upload } from "./link.js";
import { bars } from "./figures.js";
import { checksOfCard, notices, readAs } from "./checks.js";
import { observed } from "./observed.js";

export const TITLE = "Data";
const LANES = {
  learn: ["Learn from", "The model is made of these."],
  search: ["Search", "Where something may be missing is looked for in these."],
  confirm: ["Confirm", "What is found must help on these; nothing is learned from them."],
};

export function status(state) {
  const count = state.cards.length;
  return count ? `${count} recording${count > 1 ? "s" : ""}` : "drop a recording";
}

function coverage(looked) {
  return h("div", { class: "joints" }, h("b", {}, "joint"), h("b", {}, "positions"), h("b", {}, "speeds"),
    looked.joints.map((joint) => [
      h("span", { class: "name" }, joint.name),
      bars(joint.positions, `positions of ${joint.name} from ${number(joint.low)} to ${number(joint.high)} rad`),
      bars(joint.speeds, `speeds of ${joint.name} up to ${number(joint.fastest)} rad/s`)]));
}

function card(state, one) {
  const looked = one.looked;
  const facts = one.error
    ? h("p", { class: "bad" }, one.error)
    : !looked
      ? h("p", { class: "facts" }, "reading…")
      : [h("p", { class: "facts" }, `${number(looked.seconds)} s at ${number(looked.rate)} Hz, ${looked.joints.length} joints` +
          (looked.gaps ? `, ${looked.gaps} gaps` : "") + (looked.rest > 0.01 ? `, at rest ${Math.round(100 * looked.rest)} % of the time` : "")),
        coverage(looked), checksOfCard(state, one), readAs(state, one), observed(one),
        looked.notes.length ? h("details", {}, h("summary", {}, `${looked.notes.length} remark${looked.notes.length > 1 ? "s" : ""} and repairs`),
          h("ul", {}, looked.notes.map((note) => h("li", {}, note)))) : null];
  const select = h("select", { class: "pick", "data-key": "role" + one.id, "aria-label": `use of ${one.name}`,
    onchange: (event) => ask("role", { card: one.id, role: event.target.value }) },
    Object.entries({ ...LANES, aside: ["Set aside"] }).map(([role, [title]]) =>
      h("option", { value: role, selected: one.role === role }, title)));
  return h("article", { class: "card", draggable: "true",
    ondragstart: (event) => event.dataTransfer.setData("text/x-card", one.id) },
    h("h3", {}, one.name), facts,
    h("div", { class: "row" }, select,
      h("button", { class: "plain", "data-key": "gone" + one.id, "aria-label": `take ${one.name} away`, onclick: () => ask("remove", { card: one.id }) }, "Take away")));
}

function droppable(element, dropped) {
  element.addEventListener("dragover", (event) => {
    event.preventDefault();
    element.classList.add("over");
  });
  element.addEventListener("dragleave", () => element.classList.remove("over"));
  element.addEventListener("drop", (event) => {
    event.preventDefault();
    event.stopPropagation();
    element.classList.remove("over");
    dropped(event.dataTransfer);
  });
  return element;
}

async function sent(files) {
  for (const file of files) {
    await upload(file);
  }
}

export function view(state, { go }) {
  const choose = h("input", { type: "file", multiple: true, hidden: true, id: "choose", "aria-label": "recordings",
    accept: ".mcap,.db3,.csv,.npz,.zstd", onchange: (event) => sent([...event.target.files]) });
  const open = h("button", { class: "plain", "data-key": "open", onclick: () => choose.click() }, "Add recordings…");
  const ready = state.cards.some((one) => one.role === "learn" && one.looked && !one.error);
  const next = h("button", { class: "main", disabled: !ready, "data-key": "next", onclick: async () => {
    if (state.nodes.length || (await ask("learn"))) {
      go("model");
    }
  } }, state.nodes.length ? "Go to the model" : "Learn a model");
  const again = async () => {
    if (await ask("learn")) {
      go("model");
    }
  };
  const parts = [head("Recordings", "Joint states of an arm that moves: position and torque, half a minute or more, all joints at once. Two or three different motions are best.", open, next), choose,
    ...notices(state, again)];
  if (!state.cards.length) {
    parts.push(droppable(h("div", { class: "empty" }, h("h3", {}, "Drop recordings here"),
      "MCAP or db3 of a bag, CSV or NumPy. They stay on this machine."), (given) => sent([...given.files])));
    return parts;
  }
  const lanes = Object.entries(LANES).map(([role, [title, lead]]) =>
    droppable(h("section", { class: "lane" }, h("h3", {}, title), h("p", {}, lead),
      state.cards.filter((one) => one.role === role).map((one) => card(state, one))), (given) => {
      const id = given.getData("text/x-card");
      if (id) {
        ask("role", { card: id, role });
      } else {
        sent([...given.files]);
      }
    }));
  parts.push(h("div", { class: "lanes" }, lanes));
  const aside = state.cards.filter((one) => one.role === "aside");
  if (aside.length) {
    parts.push(h("h3", {}, "Set aside"), h("div", { class: "lanes" }, aside.map((one) => card(state, one))));
  }
  return parts;
}
