// The form for a run that a person measured: millimetres and degrees here, metres and radians on the wire.

import { post } from "./api.js";
import { $, announce, el, onSubmit, say } from "./dom.js";
import { cornerDrawing } from "./drawings.js";
import { t } from "./language.js";
import { metres, radians, read } from "./units.js";

const COORDINATES = { x: ["x", "mm"], y: ["y", "mm"], theta: [t("heading"), "°"] };
const WALLS = { right_front: [t("right front"), "mm"], right_rear: [t("right rear"), "mm"], behind: [t("behind"), "mm"] };
const GEOMETRY = { // [label, usual value in mm]
  baseline: [t("between the two sensors on the right"), 405],
  side: [t("these, beside the middle line"), 300],
  rear: [t("the sensor behind, from the axle"), 300],
  wall_x: [t("short wall, x"), -2500],
  wall_y: [t("long wall, y"), -6000],
};
const SECTIONS = { before: t("Before the run"), after: t("After the run"), calculated: t("Where odometry ends"), geometry: t("Geometry") };
let currentSession;
let added;
let byWalls = null;

/** `current` returns the session that is shown; `afterAdding` is called when a run was added. */
export function setUpRunForm(current, afterAdding) {
  currentSession = current;
  added = afterAdding;
  $("corner").append(cornerDrawing());
  $("calculated").append(fields("calculated", COORDINATES));
  $("geometry").querySelector(".fields").append(...Object.entries(GEOMETRY).map(([name, [label, usual]]) => field(`geometry.${name}`, label, "mm", usual)));
  for (const choice of $("sample").elements.by) choice.addEventListener("change", showFields);
  $("from-robot").addEventListener("change", showCalculated);
  onSubmit("sample", add);
  showFields();
}

export function showRunForm({ how, state, possible, counts, runs }, vehicle) {
  const was = $("sample").hidden;
  $("sample").hidden = how === "recordings" || !possible.includes("sample");
  if ($("sample").hidden) return;
  $("sample-truck").hidden = !vehicle.trucks.b;
  $("from-robot-row").hidden = state !== "measuring";
  showCalculated();
  const turn = how === "drive" ? fewer(counts) : counts.cw < runs || counts.ccw >= runs ? "cw" : "ccw";
  if (was || $("sample").dataset.next !== turn) $("sample").elements.direction.value = turn;
  $("sample").dataset.next = turn;
  const next = counts.cw + counts.ccw + 1;
  $("sample-title").textContent = next > 2 * runs ? t("One more run") : t("Next run: {next} of {all}", { next, all: 2 * runs });
}

/** The robot drives cw and ccw in turn. */
const fewer = ({ cw, ccw }) => (cw <= ccw ? "cw" : "ccw");

function showFields() {
  const walls = $("sample").elements.by.value === "walls";
  if (walls === byWalls) return;
  byWalls = walls;
  say($("sample-message"));
  $("corner").hidden = $("geometry").hidden = !walls;
  for (const when of ["before", "after"]) {
    $(when).querySelector(".fields")?.remove();
    $(when).append(fields(walls ? `${when}.walls` : when, walls ? WALLS : COORDINATES));
  }
  if (!walls) for (const name of ["x", "y", "theta"]) entry(`before.${name}`).value = "0";
}

function showCalculated() {
  $("calculated").hidden = !$("from-robot-row").hidden && $("from-robot").checked;
}

async function add() {
  const missing = [...$("sample").querySelectorAll("input[inputmode=decimal]")]
    .find((field) => field.checkVisibility() && !Number.isFinite(read(field) ?? (field.dataset.where.endsWith("theta") ? 0 : NaN)));
  if (missing) {
    missing.setAttribute("aria-invalid", "true");
    missing.focus();
    throw new Error(t("{label} is missing.", missing.dataset));
  }
  const { direction, truck } = $("sample").elements;
  const run = { direction: direction.value, truck: truck.value, before: fix("before"), after: fix("after") };
  if (!$("calculated").hidden) run.calculated = pose("calculated");
  await post(`/v1/umbmark/sessions/${currentSession().id}/samples`, run);
  for (const field of $("sample").querySelectorAll("#after input, #calculated input")) field.value = "";
  announce(t("The run is added."));
  await added();
  say($("sample-message"), t("Added."), "good");
  $("after").querySelector("input")?.focus();
}

function fix(when) {
  if (!byWalls) return pose(when);
  const lengths = (prefix, names) => Object.fromEntries(Object.keys(names).map((name) => [name, metres(read(entry(`${prefix}.${name}`)))]));
  return { walls: { ...lengths(`${when}.walls`, WALLS), geometry: lengths("geometry", GEOMETRY) } };
}

function pose(when) {
  const [x, y, theta] = ["x", "y", "theta"].map((name) => read(entry(`${when}.${name}`)));
  return { x: metres(x), y: metres(y), ...(theta === null ? {} : { theta: radians(theta) }) };
}

const entry = (where) => $("sample").querySelector(`[data-where="${where}"]`);

function fields(prefix, names) {
  return el("div", { class: "fields" }, Object.entries(names).map(([name, [label, unit]]) => field(`${prefix}.${name}`, label, unit)));
}

function field(where, label, unit, value = null) {
  const input = el("input", { inputmode: "decimal", autocomplete: "off", "data-where": where, "data-testid": where, "data-label": `${SECTIONS[where.split(".")[0]]}, ${label}`, value });
  return el("label", {}, label, el("span", { class: "unit", "data-unit": unit }, input));
}
