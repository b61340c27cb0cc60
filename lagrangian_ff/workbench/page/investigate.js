// The loop that closes itself: the arm moves, within what was permitted, until nothing is left to decide.
import { h, head, number, spoken } from "./dom.js";
import { ask } from "./link.js";
import { staircase } from "./figures.js";
import { saver } from "./save.js";
import { picture } from "./motion.js";
import { angle, confirm, names } from "./confirm.js";

export const TITLE = "Investigate";
const typed = { minutes: "4", speed: "50", topic: "", limits: "" };
// Which question was shown last, and its dialog.
const shown = { asks: "", dialog: null };

export function status(state) {
  if (state.arm.running) {
    return state.arm.asks ? "waits for you" : "under way";
  }
  const last = state.investigations.at(-1);
  const confirmed = last?.story?.turns.at(-1)?.confirmed.length;
  return !last ? "let the arm decide" : !last.story ? "ended early" : confirmed ? `${confirmed} confirmed` : "nothing confirmed";
}

// What every step shows: the button that stops the arm, and the question before it moves farther.
export function banner(state) {
  const { asks } = state.arm;
  if (asks !== shown.asks) {
    shown.asks = asks;
    shown.dialog?.close();
    if (asks) {
      look();
    }
  }
}

function over(found) {
  return found.share < 1 ? `${Math.round(100 * found.share)} % of the way from where it stands to the limits; it asks again before more` : "up to the limits";
}

async function look() {
  const found = await ask("question");
  if (!found || shown.dialog?.open) {
    return;
  }
  shown.dialog = confirm({
    title: found.number > 1 ? "Move the arm farther?" : "Move the arm?",
    rows: [["Arm", names(found.joints)], ["Topic", found.topic], ["Who takes it", names(found.nodes)],
      ["Duration", `up to ${number(found.seconds)} s of motion, in several motions that it designs itself`],
      ["Range", over(found)],
      ["Way to the start", "Each motion begins and ends where the arm stands now. If it is moved between two motions, it first goes back there, at no more than 0.3 rad/s."]],
    header: ["joint", "is at [rad]", "lowest [rad]", "highest [rad]", "fastest [rad/s]"],
    joints: found.joints.map((joint, n) => [joint, angle(found.start[n]), angle(found.low[n]), angle(found.high[n]), number(found.fastest[n])]),
    notes: [found.clear ? "Links keep clear of each other. Nobody checks what stands around the arm: see that the whole range is free."
      : "Nobody checks whether the arm touches itself or what stands around it: see that the whole range is free."],
    no: { words: "Do not move", act: () => ask("refuse") },
    yes: { words: "Move the arm", act: () => ask("permit", { token: found.token }) },
  });
}

function command(text) {
  return h("pre", { tabindex: "0" }, text);
}

function quoted(text) {
  return /^[\w./+=-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`;
}

function lacking(state) {
  return [h("section", { class: "card" }, h("h3", {}, "It needs an arm"),
    h("p", {}, "An investigation moves an arm by itself. Start the workbench beside a robot that publishes joint states and takes trajectories, in a shell with ROS 2:"),
    command(`lagrangian_ff workbench --live --session ${quoted(state.arm.session)} --urdf robot.urdf`),
    h("p", { class: "lead-up" }, "Without a page:"),
    command("lagrangian_ff investigate --topic /joint_trajectory_controller/joint_trajectory --urdf robot.urdf --report story.html"),
    h("p", { class: "lead-up" }, "To try it without a robot, on a simulated arm that hides an effect:"),
    command("lagrangian_ff workbench --try --session trial"))];
}

async function limits(file) {
  if (file && (await ask("limits", { name: file.name, text: await file.text() }))) {
    typed.limits = "file";
  }
}

function select(key, label, values) {
  const chosen = values.some(([value]) => value === typed[key]) ? typed[key] : values[0]?.[0] ?? "";
  typed[key] = chosen;
  return h("label", { class: "field" }, label, h("select", { class: "pick", "data-key": key, onchange: (event) => { typed[key] = event.target.value; } },
    values.map(([value, words]) => h("option", { value, selected: value === chosen }, words))));
}

function field(key, label, range) {
  return h("label", { class: "field" }, label, h("input", { type: "number", ...range, value: typed[key], "data-key": key,
    oninput: (event) => { typed[key] = event.target.value; } }));
}

function form(state, busy) {
  const robot = state.arm.kind === "robot", topics = state.live?.topics || [];
  const within = [...(state.arm.urdf ? [["urdf", `those of ${state.arm.urdf}`]] : []), ...(state.arm.limits ? [["file", "the file of joint limits"]] : [])];
  const choose = h("input", { type: "file", hidden: true, id: "limits", "aria-label": "file of joint limits", accept: ".yaml,.yml",
    onchange: (event) => limits(event.target.files[0]) });
  const start = h("button", { class: "main", "data-key": "investigate", disabled: busy || (robot && (!topics.length || !within.length)), onclick: () =>
    ask("investigate", { minutes: Number(typed.minutes), speed: Number(typed.speed) / 100, topic: typed.topic, limits: typed.limits }) }, "Investigate");
  const lacks = !robot ? null
    : !topics.length ? "Nobody in the graph takes a trajectory (trajectory_msgs/JointTrajectory)."
      : !within.length ? "Say where the arm may go: choose a file of joint limits as MoveIt's joint_limits.yaml, or start the workbench with --urdf." : null;
  return h("section", { class: "card" }, h("h3", {}, robot ? "The arm in the ROS graph" : "The simulated arm"),
    h("p", { class: "quiet" }, robot ? "Nothing moves before you have permitted it; it asks again before each larger range. Motions begin and end where the arm stands when you click."
      : "The arm of this session's recordings, with the effect that hides in it. It moves faster than real time, and nothing can break."),
    h("div", { class: "row wishes" }, field("minutes", "Minutes of motion", { min: 0.15, max: 60, step: "any" }), field("speed", "Speed [% of the highest]", { min: 1, max: 100, step: 1 }),
      robot && topics.length ? select("topic", "Topic", topics.map((one) => [one, one])) : null,
      robot && within.length ? select("limits", "Limits", within) : null,
      robot ? [choose, h("button", { class: "plain", "data-key": "chooselimits", onclick: () => choose.click() }, "File of joint limits…")] : null, start),
    lacks ? h("p", { class: "bad under" }, lacks) : null);
}

// What was asked so far, while the answers come.
function steps(one) {
  if (!one.steps.length) {
    return h("p", { class: "quiet" }, "It has not moved yet.");
  }
  return h("ol", { class: "asked" }, one.steps.map((step) => h("li", {}, h("b", {}, step.words),
    h("p", { class: "quiet" }, `A motion of ${number(step.seconds)} s` + (step.expected === null ? "." : `, expected to gain ${number(step.expected)} nats.`)),
    h("p", {}, step.answer || "…"))));
}

function underWay(state, one) {
  return h("section", { class: "card", "aria-live": "polite" }, h("h3", {}, "Under way"),
    state.arm.asks ? h("p", { class: "row lead-up" }, h("span", {}, "It waits for your permission to move."),
      h("button", { class: "main", "data-key": "lookagain", onclick: look }, "Look at what it would do"),
      h("button", { class: "plain", "data-key": "refuse", onclick: () => ask("refuse") }, "Do not move")) : null,
    steps(one));
}

function fall(story) {
  const found = story.turns.map(({ rmse, errors }, k) => ({ title: `question ${k + 1}`, rmse, errors }));
  const curves = story.unlisted && story.unlisted.left.some((one) => one.taken);
  return curves ? [...found, { title: "with curves", rmse: story.unlisted.rmse, errors: story.unlisted.errors }] : found;
}

function expectation(one) {
  if (one.expected_nats === null) {
    return ".";
  }
  return `, expected to gain ${number(one.expected_nats)} nats` + (one.gained_nats === null ? "." : `; ${number(one.gained_nats)} are for it now.`);
}

function turn(story, one, k) {
  return h("section", { class: "card finding" }, h("div", {}, h("h3", {}, `${k + 1}. ${one.asked}`),
    h("p", {}, one.answer),
    h("p", { class: "quiet" }, `A motion of ${number(one.seconds)} s${expectation(one)}`),
    one.confirmed.length ? h("p", { class: "quiet" }, `Confirmed by then: ${one.confirmed.map(spoken).join(", ")}.`) : null),
  h("div", { class: "drawn" }, picture(story.pictures[k])));
}

function told(state, one, go) {
  const { story } = one;
  const why = h("p", {}, `It ended${story ? ` after ${number(story.seconds)} s of motion` : ""}: ${one.words}.`);
  const about = h("p", { class: "quiet" }, one.bags.length ? `Its ${one.bags.length} motion${one.bags.length > 1 ? "s are cards" : " is a card"} under Data.` : "The arm did not move.");
  if (!story || !story.turns.length) {
    return [h("section", { class: "card" }, h("h3", {}, one.title), why, about, one.steps.length ? steps(one) : null)];
  }
  const models = fall(story), { joints } = story;
  const falls = models.length > story.turns.length || story.turns.at(-1).confirmed.length > 0;
  // The last model, which has learned from every motion, less what was found.
  const without = falls ? { title: "without what was found", ...story.before } : null;
  const figure = staircase(models, 640, 130, without), columns = without ? [without, ...models] : models;
  return [h("div", { class: "two" }, h("section", { class: "card drawn" }, h("h3", {}, `I${one.title.slice(1)}: the error${falls ? " falls" : ""}`), figure, saver(figure, one.id),
    h("details", {}, h("summary", {}, "Error of each joint"), h("div", { class: "wide" }, h("table", { class: "close" }, h("thead", {}, h("tr", {}, h("th", {}, "unseen error [N·m]"), columns.map(({ title }) => h("th", { class: "number" }, title)))),
      h("tbody", {}, joints.map((joint) => h("tr", {}, h("td", {}, joint), columns.map(({ errors }) => h("td", { class: "number" }, number(errors[joint]))))),
        h("tr", {}, h("td", {}, "all"), columns.map(({ rmse }) => h("td", { class: "number total" }, number(rmse))))))))),
  h("section", { class: "card end" }, h("h3", {}, "In the end"), why, h("ul", {}, story.left.map((text) => h("li", {}, text))), about,
    h("p", { class: "quiet" }, "The model is a step, with each effect that was added before it."),
    h("div", { class: "row lead-up" }, h("button", { class: "main", "data-key": "tosteps", onclick: async () => {
      if (!one.node || (await ask("look", { model: one.node }))) {
        go("history");
      }
    } }, "Go to its steps"),
    h("a", { class: "plain", href: `api/page/investigation/${one.id}`, download: "investigation.html", "data-key": "story" + one.id }, "Page of the story")))),
  ...story.turns.map((each, k) => turn(story, each, k))];
}

export function view(state, { go }) {
  const running = state.investigations.find((one) => one.id === state.arm.running);
  const over = [...state.investigations].reverse().filter((one) => one !== running);
  const [last, ...older] = over;
  return [head("Investigate", "The arm moves by itself: it identifies a model, finds what that lacks, designs the motion that decides what is open, and moves again, until nothing is open or the time is used."),
    ...(running ? [underWay(state, running)] : state.arm.kind ? [form(state, state.work.length > 0)] : lacking(state)),
    ...(last && !running ? told(state, last, go) : []),
    ...(running ? over : older).map((one) => h("details", {}, h("summary", {}, `${one.title}: ${one.words}`), told(state, one, go)))];
}
