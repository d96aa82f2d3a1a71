// The event stream, read by fetch because EventSource cannot send a key; it reconnects after each failure.

import { call } from "./api.js";

const SILENCE = 6000; // [ms] after which the connection is taken for lost; ten events a second are expected
const LONGEST_PAUSE = 10; // [s] between two attempts
const listeners = { state: [], nodes: [], session: [], job: [], link: [] };
let wake = () => {};

/** Call a listener at each event: state, nodes, session, job, or link (the connection: {now, wait}). */
export function on(kind, listener) {
  listeners[kind].push(listener);
}

/** Connect, and stay connected. */
export async function start() {
  document.addEventListener("key-given", () => wake());
  addEventListener("online", () => wake());
  for (let pause = 1; ; pause = Math.min(2 * pause, LONGEST_PAUSE)) {
    notify("link", { now: "connecting" });
    const began = performance.now();
    const status = await connection();
    if (performance.now() - began > 1000 * LONGEST_PAUSE) pause = 1;
    await waitToReconnect(status === 401 ? Infinity : pause);
  }
}

async function connection() {
  const stop = new AbortController();
  let watch = setTimeout(() => stop.abort(), SILENCE);
  try {
    const answer = await call("GET", "/v1/robot/stream", { headers: { Accept: "text/event-stream" }, signal: stop.signal });
    notify("link", { now: "live" });
    let rest = "";
    const reader = answer.body.pipeThrough(new TextDecoderStream()).getReader();
    for (let part = await reader.read(); !part.done; part = await reader.read()) {
      clearTimeout(watch);
      watch = setTimeout(() => stop.abort(), SILENCE);
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
  if (data.length && kind in listeners) notify(kind, JSON.parse(data.join("\n")));
}

function notify(kind, event) {
  for (const listener of listeners[kind]) listener(event);
}

async function waitToReconnect(seconds) {
  const woken = new Promise((done) => (wake = done));
  if (!Number.isFinite(seconds)) {
    notify("link", { now: "key" });
    return woken;
  }
  notify("link", { now: "lost", wait: seconds });
  return Promise.race([woken, new Promise((done) => setTimeout(done, 1000 * seconds))]);
}
