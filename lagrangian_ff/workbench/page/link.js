// The other end: what the server tells, and what is asked of it.
export const link = { state: null, listeners: [] };

export function follow(listener) {
  link.listeners.push(listener);
}

export function open() {
  const source = new EventSource("api/events");
  source.onmessage = (event) => {
    link.state = { ...link.state, ...JSON.parse(event.data) };
    link.listeners.forEach((listener) => listener(link.state));
  };
  source.onerror = () => say("The server does not answer. It goes on where it was when it is started again.");
  source.onopen = () => say("");
}

export function say(text) {
  const place = document.getElementById("said");
  place.replaceChildren();
  if (text) {
    const close = document.createElement("button");
    close.textContent = "Close";
    close.addEventListener("click", () => place.replaceChildren());
    place.append(text, close);
  }
}

// Returns what was answered, or false after saying why not.
async function answered(response) {
  if (response.ok) {
    return response.json();
  }
  let words = "The server answered " + response.status;
  try {
    words = (await response.json()).error || words;
  } catch {
    // it said nothing more
  }
  say(words);
  return false;
}

export async function ask(what, asked = {}, where = "api/ask/") {
  try {
    const response = await fetch(where + what, { method: "POST", body: JSON.stringify(asked) });
    return await answered(response);
  } catch {
    say("The server does not answer. Is it still running?");
    return false;
  }
}

export async function upload(file) {
  try {
    const response = await fetch("api/upload?name=" + encodeURIComponent(file.name), { method: "POST", body: file });
    return await answered(response);
  } catch {
    say(file.name + " could not be sent.");
    return false;
  }
}

// Returns what the server has at an address, read as "json" or "arrayBuffer"; null if it has nothing.
export async function got(address, kind) {
  try {
    const response = await fetch(address);
    return response.ok ? await response[kind]() : null;
  } catch {
    return null; // that the server has gone, its events say
  }
}

// Curves between two times: {time, series: {name: [joint] -> {low, high}}}.
export async function trace(node, start, end, width, names) {
  const query = names.map((name) => "&series=" + name).join("");
  const data = await got(`api/trace/${node}?start=${start}&end=${end}&width=${width}${query}`, "arrayBuffer");
  if (!data) {
    return null;
  }
  const [count, joints] = new Int32Array(data, 0, 3);
  const numbers = new Float32Array(data, 12);
  let at = 0;
  const next = () => numbers.subarray(at, (at += count));
  const time = next();
  const series = {};
  for (const name of names) {
    const low = Array.from({ length: joints }, next);
    const high = Array.from({ length: joints }, next);
    series[name] = low.map((one, n) => ({ low: one, high: high[n] }));
  }
  return { time, series };
}

export function current(state) {
  return state.nodes.find((node) => node.id === state.current) || null;
}
