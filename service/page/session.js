// A UMBmark session: its state, its runs as they come, and the calls that it allows.

import { get, post, remove } from "./api.js";
import { $, actionButton, announce, attempt, el, row, say, showing } from "./dom.js";
import { clusterDrawing, reach, sums } from "./clusters.js";
import { t } from "./language.js";
import { Plan } from "./plan.js";
import { clearResult, showResult } from "./result.js";
import { setUpRunForm, showRunForm } from "./run-form.js";
import { on } from "./stream.js";
import { showRecordedRuns } from "./recorded-runs.js";
import { deg, mm, number, size } from "./units.js";
import { STATES } from "./session-list.js";

const STEP = { driving: 1, measuring: 1, collecting: 1, interrupted: 1, solved: 3, accepted: 4 };
let now = null; // the session that is shown
let vehicle = null;
let requests = 0;
let plan;

export const address = (session, ...more) => ["/v1/umbmark/sessions", session.id, ...more].join("/");

export function setUpSession() {
  plan = new Plan($("small-plan"));
  setUpRunForm(() => now, reload);
  const setUpButton = (id, work) => $(id).addEventListener("click", () => attempt($(id), $("session-message"), work));
  setUpButton("solve", async () => {
    await post(address(now, "solve"), {});
    await reload();
    $("result").scrollIntoView({ block: "start" });
  });
  setUpButton("resume", async () => reload(await post(address(now, "resume"))));
  setUpButton("abort", async () => reload(await post(address(now, "abort"))));
  on("state", showState);
  on("session", ({ id }) => now?.id === id && !$("session").hidden && reload());
  on("link", ({ now: link }) => link === "live" && now && !$("session").hidden && reload());
}

export async function openSession(id) {
  if (now?.id !== id) forget();
  await showing($("session-message"), async () => {
    now = await get(`/v1/umbmark/sessions/${encodeURIComponent(id)}`);
    vehicle = await get(`/v1/vehicles/${encodeURIComponent(now.vehicle)}`);
    plan.vehicle = vehicle;
    await showSession();
    say($("session-message"));
  });
}

/** Show the session as it is now. Of several simultaneous requests, the newest one counts. */
async function reload() {
  const request = (requests += 1);
  await showing($("session-message"), async () => {
    const session = await get(address(now));
    if (request !== requests || session.id !== now.id) return;
    if (session.detail !== now.detail) announce(session.detail);
    now = session;
    await showSession();
  });
}

function forget() {
  now = null;
  clearResult();
  plan.forget();
  $("clusters").replaceChildren();
  $("runs").replaceChildren();
  for (const id of ["driving", "recorded-runs", "sample"]) $(id).hidden = true;
}

async function showSession() {
  const { state, how, possible, side, detail } = now;
  $("session-title").textContent = t("UMBmark of {vehicle}, {square}", { vehicle: now.vehicle, square: `${[side, side].map((length) => number(length, length % 1 ? 2 : 0)).join("\u00a0×\u00a0")}\u00a0m` });
  $("session-state").textContent = STATES[state];
  $("session-state").className = `chip ${state}`;
  say($("session-detail"), state === "solved" ? t("Look at the result, then accept it, or add runs and solve again.") : detail);
  const counts = now.counts;
  [...$("steps").children].forEach((item, index) => {
    const step = state === "collecting" && counts.cw && counts.ccw && enough() ? 2 : (STEP[state] ?? 1);
    item.className = index < step ? "done" : "";
    item.toggleAttribute("aria-current", index === step);
  });
  for (const name of ["solve", "resume", "abort"]) $(name).hidden = !possible.includes(name);
  $("solve").hidden ||= !counts.cw || !counts.ccw;
  $("solve").className = enough() && state !== "solved" ? "primary" : "quiet";
  $("solve").textContent = state === "solved" ? t("Solve again") : t("Solve");
  $("driving").hidden = how !== "drive";
  showLaps();
  showRuns();
  showRunForm(now, vehicle);
  await showRecordedRuns(now, reload);
  if (["solved", "accepted"].includes(state)) await showResult(now, reload);
  else clearResult();
}

function showState(state) {
  if ($("session").hidden || $("driving").hidden || !state.plain) return;
  const turned = state.lap !== plan.lap;
  plan.square = { side: now.side, direction: state.lap ?? "cw" };
  plan.show(state);
  if (turned) showLaps();
}

const enough = () => now.counts.cw >= now.runs && now.counts.ccw >= now.runs;

/** A dot for each run that is wanted, filled when the run is there. */
function showLaps() {
  $("laps").replaceChildren(...["cw", "ccw"].map((direction) => {
    const count = now.counts[direction];
    const current = now.state === "driving" && plan.lap === direction;
    const dots = Array.from({ length: Math.max(now.runs, count) }, (_, index) =>
      el("i", { class: `shape ${direction}${index < count ? " full" : ""}${current && index === count ? " current" : ""}` }));
    return el("p", { "data-testid": `laps-${direction}`, "aria-label": t("{direction}: {count} of {runs} runs", { direction, count, runs: now.runs }) }, el("span", {}, direction), ...dots, el("b", {}, t("{count} of {runs}", { count, runs: now.runs })));
  }));
}

function showRuns() {
  const trucks = Object.keys(vehicle.trucks).filter((truck) => now.samples.some(({ errors }) => errors[truck]));
  const edge = reach(now.samples);
  $("clusters").replaceChildren(...trucks.map((truck) => {
    const { centres, largest } = sums(now.samples, truck);
    const caption = Object.keys(centres).length === 2 ? [": E", el("sub", {}, "max,syst"), ` ${size(largest)}`] : [];
    return el("figure", {}, clusterDrawing(now.samples, truck, edge), el("figcaption", {}, t("truck {truck}", { truck }), caption));
  }));
  if (!trucks.length) $("clusters").append(el("p", { class: "soft" }, t("Each run appears here as soon as it is measured.")));
  const leave = now.possible.includes("remove");
  $("runs").replaceChildren(...now.samples.flatMap((sample) => trucks.filter((truck) => sample.errors[truck]).map((truck, index) => {
    const { x, y, theta } = sample.errors[truck];
    return row(
      index ? "" : el("span", {}, el("i", { class: `shape ${sample.direction}` }), ` ${sample.number} ${sample.direction}`),
      truck, mm(x, 1), mm(y, 1), deg(theta),
      leave && !index ? leaveOut(sample) : "",
    );
  })));
  $("runs-details").hidden = !now.samples.length;
}

function leaveOut(sample) {
  return actionButton(t("Leave out"), $("runs-message"), async () => {
    await remove(address(now, "samples", sample.number));
    await reload();
  }, { "data-testid": `leave-out-${sample.number}`, "aria-label": t("Leave run {number} out", sample) });
}
