// The stream of the robot, read by fetch (EventSource sends no key); it connects again whenever it breaks.

import { call } from "./api.js";

const SILENT = 6000; // [ms]: ten events a second are expected
const LONGEST = 10; // [s] between two attempts
const listeners = { state: [], nodes: [], session: [], job: [], link: [] };
let wake = () => {};

/** Be told of events: state, nodes, session, job, or link (the connection: {now, wait}). */
export function on(kind, listener) {
  listeners[kind].push(listener);
}

/** Connect, and stay connected. */
export async function start() {
  document.addEventListener("key-given", () => wake());
  addEventListener("online", () => wake());
  for (let pause = 1; ; pause = Math.min(2 * pause, LONGEST)) {
    tell("link", { now: "connecting" });
    const began = performance.now();
    const status = await connection();
    if (performance.now() - began > 1000 * LONGEST) pause = 1;
    await rest(status === 401 ? Infinity : pause);
  }
}

async function connection() {
  const stop = new AbortController();
  let watch = setTimeout(() => stop.abort(), SILENT);
  try {
    const answer = await call("GET", "/v1/robot/stream", { headers: { Accept: "text/event-stream" }, signal: stop.signal });
    tell("link", { now: "live" });
    let rest = "";
    const reader = answer.body.pipeThrough(new TextDecoderStream()).getReader();
    for (let part = await reader.read(); !part.done; part = await reader.read()) {
      clearTimeout(watch);
      watch = setTimeout(() => stop.abort(), SILENT);
      const events = (rest + part.value).replaceAll("\r\n", "\n").split("\n\n");
      rest = events.pop();
      events.forEach(dispatch);
    }
  } catch (problem) {
    return problem.status;
  } finally {
    clearTimeout(watch);
  }
  return null;
}

function dispatch(text) {
  let kind = "message";
  const data = [];
  for (const line of text.split("\n")) {
    if (line.startsWith("event:")) kind = line.slice(6).trim();
    else if (line.startsWith("data:")) data.push(line.slice(5).trimStart());
  }
  if (data.length && kind in listeners) tell(kind, JSON.parse(data.join("\n")));
}

function tell(kind, event) {
  for (const listener of listeners[kind]) listener(event);
}

async function rest(seconds) {
  const woken = new Promise((done) => (wake = done));
  if (!Number.isFinite(seconds)) {
    tell("link", { now: "key" });
    return woken;
  }
  tell("link", { now: "lost", wait: seconds });
  return Promise.race([woken, new Promise((done) => setTimeout(done, 1000 * seconds))]);
}
