// A fleet at a glance: which robots are fine, drift, are faulty; the floor's map; batches with their progress.

import { call, get, post } from "./api.js";
import { JOB_STATES } from "./diagnoses.js";
import { $, actionButton, announce, attempt, el, onSubmit, pages, say, show, showing } from "./dom.js";
import { floorMap } from "./fleet-drawings.js";
import { placeSays, robotSays } from "./fleet-words.js";
import { t } from "./language.js";
import { on } from "./stream.js";
import { attempts, recordingsCount, when } from "./units.js";
import { setUpUpload } from "./upload.js";

export const STATES = { sick: t("faulty"), drift: t("drift"), fine: t("fine"), unjudged: t("not judged") };
const MOST = 2000; // robots of a page
const SHOWN_REFUSED = 20; // recordings of an upload
let fleet = null;

export const address = (name, ...more) => ["/v1/fleets", ...[name, ...more].map(encodeURIComponent)].join("/");

export function setUpFleet() {
  $("fleet-name").addEventListener("change", () => (location.hash = `#fleet/${encodeURIComponent($("fleet-name").value)}`));
  $("fleet-floor-name").addEventListener("change", async () => showFloor(await get(`${address(fleet, "nights", "latest", "floor")}?floor=${encodeURIComponent($("fleet-floor-name").value)}`)));
  onSubmit("fleet-start", make);
  setUpUpload("fleet-", upload);
  $("batch-start").addEventListener("click", () => attempt($("batch-start"), $("batch-message"), async () => {
    await post(address(fleet, "batches"), { diagnose: $("fleet-diagnose").checked });
    await listBatches();
  }));
  on("job", showBatch);
  on("link", ({ now }) => now === "live" && !$("fleet").hidden && fleet && listBatches());
}

/** Show a fleet; without a name, the newest one. */
export async function openFleet(name) {
  await showing($("fleet-message"), async () => {
    const { items } = await get("/v1/fleets?limit=200");
    fleet = name ?? fleet ?? items[0]?.name ?? null;
    $("fleet-name").replaceChildren(...items.map((each) => el("option", { value: each.name }, each.name)));
    $("fleet-name").hidden = items.length < 2;
    $("fleet-upload-card").hidden = fleet === null;
    say($("fleet-message"));
    if (fleet === null) {
      $("fleet-title").textContent = t("Fleet");
      return;
    }
    $("fleet-name").value = fleet;
    await Promise.all([showFleet(), listBatches()]);
  });
}

async function make() {
  const made = await post("/v1/fleets", { name: $("fleet-new").value });
  $("fleet-new").value = "";
  location.hash = `#fleet/${encodeURIComponent(made.name)}`;
}

async function showFleet() {
  const about = await get(address(fleet));
  $("fleet-title").textContent = t("Fleet {name}", about);
  $("fleet-night").textContent = about.night ? t("report of {night}", about) : t("no daily report yet");
  $("fleet-states").replaceChildren(...Object.entries(STATES)
    .filter(([state]) => about.states[state] || state !== "unjudged")
    .map(([state, word]) => el("li", { class: state, "data-testid": `state-${state}` }, el("b", {}, `${about.states[state] ?? 0}`), ` ${word}`)),
    el("li", { class: "places", "data-testid": "state-places" }, el("b", {}, `${about.places}`), " ", about.places === 1 ? t("bad place") : t("bad places")));
  for (const id of ["fleet-robots", "fleet-floor"]) $(id).hidden = about.night === null;
  if (about.night === null) return;
  const [robots, night, floor] = await Promise.all([allRobots(), get(address(fleet, "nights", "latest")), get(address(fleet, "nights", "latest", "floor"))]);
  $("robot-dots").replaceChildren(...robots.map(dot));
  const named = robots.filter(robotSays).sort((a, b) => Object.keys(STATES).indexOf(a.state) - Object.keys(STATES).indexOf(b.state));
  $("robot-findings").replaceChildren(...named.map(findingItem), ...night.failed.map(failedItem));
  $("no-findings").hidden = named.length > 0 || night.failed.length > 0;
  $("no-findings").textContent = night.judged ? t("No robot stands out.") : t("Robots are judged from three days on.");
  $("fleet-floor-name").replaceChildren(...night.floors.map((each) => el("option", { value: each.floor }, each.floor || t("unnamed"))));
  $("fleet-floor-name").hidden = night.floors.length < 2;
  showFloor(floor);
}

/** Show one of the fleet's floors. */
function showFloor(floor) {
  $("fleet-floor-name").value = floor.floor;
  $("fleet-map").replaceChildren(floorMap(floor));
  $("fleet-places").replaceChildren(...floor.places.map((place) => el("li", {}, el("p", {}, el("i", { class: `shape ${place.effect}place`, "aria-hidden": "true" }), ` ${placeSays(place)}`))));
}

async function allRobots() {
  const robots = [];
  for (let after = ""; after !== null;) {
    const { items, next } = await get(`${address(fleet, "robots")}?limit=${MOST}${after ? `&after=${encodeURIComponent(after)}` : ""}`);
    robots.push(...items);
    after = next;
  }
  return robots;
}

const link = (robot) => `#fleet/${encodeURIComponent(fleet)}/${encodeURIComponent(robot)}`;

function dot({ robot, state }) {
  return el("li", {}, el("a", { href: link(robot), class: state, title: `${robot}: ${STATES[state]}`, "data-testid": `dot-${robot}` }, el("span", { class: "unseen" }, `${robot}: ${STATES[state]}`)));
}

function findingItem(about) {
  const { robot, state } = about;
  return el("li", { "data-testid": `finding-${robot}` },
    el("p", {}, el("span", { class: `chip ${state}` }, STATES[state]), " ", el("a", { href: link(robot) }, robot)),
    el("p", { class: "says" }, robotSays(about)));
}

function failedItem({ robot, recording, problem }) {
  return el("li", {}, el("p", {}, el("span", { class: "chip failed" }, t("no results")), " ", el("a", { href: link(robot) }, robot), `, ${recording}`), el("p", { class: "says" }, problem));
}

async function upload(file) {
  const answer = await call("POST", address(fleet, "recordings"), { body: file, type: "application/zip" });
  const { recordings, robots, days, refused } = await answer.json();
  const robotsCount = robots.length === 1 ? t("1 robot") : t("{count} robots", { count: robots.length });
  const stored = t("{recordings} of {robots} stored: {days}.", { recordings: recordingsCount(recordings), robots: robotsCount, days: days.join(", ") });
  if (!refused.length) return stored;
  const problems = refused.slice(0, SHOWN_REFUSED).map(({ problem }) => problem).join("; ") + (refused.length > SHOWN_REFUSED ? " …" : "");
  throw new Error(`${stored} ${t("{recordings} not readable and not stored: {problems}", { recordings: recordingsCount(refused.length), problems })}`);
}

async function listBatches() {
  await pages(address(fleet, "batches"), 5, $("batches"), batchItem, $("no-batches"), $("more-batches"));
}

/** Show a batch's progress as it comes, and what it found when it is done. */
async function showBatch(batch) {
  if (batch.kind !== "batch" || batch.fleet !== fleet) return;
  $("batches").querySelector(`[data-job="${batch.id}"]`)?.replaceWith(batchItem(batch));
  if (batch.state === "done" && !$("fleet").hidden) {
    announce(t("The batch is done: {done} recordings worked on.", batch));
    await showFleet().catch((problem) => show($("fleet-message"), problem));
  }
}

function batchItem(batch) {
  const going = batch.state === "queued" || batch.state === "running";
  const results = batch.done === null ? "" : t("{done} recordings worked on, {known} known before", batch);
  return el("li", { "data-job": batch.id, "data-testid": `batch-${batch.id}`, "data-state": batch.state },
    el("p", {}, el("span", { class: `chip ${batch.state}` }, JOB_STATES[batch.state]), el("span", { class: "soft" }, ` ${when(batch.created)}${batch.day ? t(", recordings of {day}", batch) : ""}${attempts(batch)}`)),
    going ? el("label", { class: "progress" }, el("progress", { value: batch.progress, max: 1 }), ` ${batch.doing || JOB_STATES[batch.state]}`) : null,
    results ? el("p", { class: "says" }, results) : null,
    batch.note ? el("p", { class: "soft" }, batch.note) : null,
    batch.failures.map(({ robot, day, recording, problem }) => el("p", { class: "message", "data-kind": "wrong" }, `${robot}, ${day}, ${recording}: ${problem}`)),
    batch.error ? el("p", { class: "message", "data-kind": "wrong" }, batch.error) : null,
    going ? el("div", { class: "buttons" }, actionButton(t("Cancel"), $("batch-message"), () => post(address(fleet, "batches", batch.id, "cancel")))) : null);
}
