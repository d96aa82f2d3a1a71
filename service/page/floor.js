// The view of the floor: the plan and, beside it, what the bus says.

import { $, el, row } from "./dom.js";
import { deg, mm, number, wrap } from "./units.js";
import { get } from "./api.js";
import { t } from "./language.js";
import { showLearned } from "./learned.js";
import { ESTIMATES, Plan, best } from "./plan.js";
import { on } from "./stream.js";

const UPDATE_PERIOD = 250; // [ms] between two updates of the numbers
const LEARNED_PERIOD = 5000; // [ms] between two looks at what the filter has learned
let plan;
let vehicle = null;
let shownAt = 0;
let learnedAt = -LEARNED_PERIOD;
let session = null; // that the robot drives for

export function setUpFloor() {
  plan = new Plan($("plan"));
  plan.viewport.listen();
  $("zoom-in").addEventListener("click", () => plan.viewport.zoom(1.4));
  $("zoom-out").addEventListener("click", () => plan.viewport.zoom(1 / 1.4));
  $("fit").addEventListener("click", () => plan.viewport.release());
  $("clear").addEventListener("click", () => plan.forget());
  $("legend").append(...Object.entries(ESTIMATES).map(([name, { label }]) => legendEntry(name, label)),
    el("li", {}, el("i", { class: "stroke sigma" }), t("2 sigma")));
  on("state", show);
  on("nodes", ({ nodes }) => $("nodes").replaceChildren(...nodes.map(nodeLamp)));
}

export function showVehicle(robot) {
  vehicle = plan.vehicle = robot;
  plan.redraw();
}

function legendEntry(name, label) {
  const button = el("button", { type: "button", "aria-pressed": "true", "data-testid": `trail-${name}` }, el("i", { class: `stroke ${name}` }), label);
  button.addEventListener("click", () => {
    const hide = !plan.hidden.has(name);
    if (hide) plan.hidden.add(name);
    else plan.hidden.delete(name);
    button.setAttribute("aria-pressed", String(!hide));
    plan.redraw();
  });
  return el("li", {}, button);
}

function show(state) {
  if (state.driving !== session?.id) follow(state.driving);
  plan.square = session?.side && state.lap ? { side: session.side, direction: state.lap } : null;
  plan.show(state);
  if ($("floor").hidden || performance.now() - shownAt < UPDATE_PERIOD) return;
  shownAt = performance.now();
  if (state.plain) {
    showPoses(state);
    showCorrections(state);
  }
  if (state.filter && performance.now() - learnedAt >= LEARNED_PERIOD && !$("learned-live").contains(document.activeElement)) followLearned();
}

async function followLearned() {
  learnedAt = performance.now();
  const path = "/v1/robot/learned";
  const learned = await get(path).catch(() => null);
  $("learned").hidden = !learned;
  if (learned) showLearned($("learned-live"), $("learned-message"), learned, path, followLearned);
}

function showPoses(state) {
  const line = (name, { x, y, theta }, digits) => row(el("th", { scope: "row" }, name), mm(x, digits), mm(y, digits), deg(wrap(theta), 1 + digits));
  const estimates = Object.entries({ plain: t("plain"), ipec: "IPEC", filter: t("filter") }).filter(([name]) => state[name]);
  $("where").replaceChildren(
    ...estimates.map(([name, word]) => line(el("span", { class: `ofkind ${name}` }, word), state[name], 0)),
    ...(state.sigma ? [line(t("± sigma"), state.sigma, 1)] : []),
  );
  const { x, y, theta } = best(state);
  const { plain } = state;
  $("off").textContent = estimates.length > 1
    ? t("Plain odometry is off by {distance} mm and {angle}°.", { distance: mm(Math.hypot(plain.x - x, plain.y - y)), angle: deg(Math.abs(wrap(plain.theta - theta)), 1) })
    : "";
  $("plan").setAttribute("aria-label", t("Floor plan; truck a at x {x} mm, y {y} mm, heading {heading}°", { x: mm(x), y: mm(y), heading: deg(wrap(theta), 0) }));
}

/** Ask for the side of a session's square. */
async function follow(id) {
  session = id ? { id } : null;
  if (!id) return;
  const answer = await get(`/v1/umbmark/sessions/${id}`).catch(() => null);
  if (session?.id === id) session.side = answer?.side;
}

function showCorrections({ corrections, lost, joints, wheels }) {
  const trucks = wheels?.length === 2 ? ["a"] : ["a", "b"];
  const line = (name, unit, value) => row(el("th", { scope: "row" }, name, " ", el("small", {}, unit)), ...trucks.map(value));
  $("corrections").replaceChildren(
    el("thead", {}, row("", ...trucks.map((truck) => el("th", { scope: "col" }, t("truck {truck}", { truck }))))),
    el("tbody", {},
      corrections ? line(t("heading"), "°", (truck) => deg(corrections[truck], 3)) : null,
      lost ? line(t("left wheel, lost travel"), "mm", (truck) => mm(lost[`${truck}.left`], 1)) : null,
      lost ? line(t("right wheel, lost travel"), "mm", (truck) => mm(lost[`${truck}.right`], 1)) : null,
      joints ? line(t("joint"), "°", (truck) => deg(joints[truck], 1)) : null,
      wheels?.length ? line(t("left wheel"), "mm/s", (truck, index) => mm(wheels[2 * index] * radius(truck, "left"))) : null,
      wheels?.length ? line(t("right wheel"), "mm/s", (truck, index) => mm(wheels[2 * index + 1] * radius(truck, "right"))) : null));
  $("link").textContent = joints ? t("The link is {length} mm long.", { length: mm(joints.length, 1) }) : "";
}

const radius = (truck, side) => (vehicle?.trucks[truck]?.[`wheel_diameter_${side}`] ?? NaN) / 2;

function nodeLamp(node) {
  const faults = [[t("missing"), node.missing], [t("restarts"), node.restarts], [t("emergencies"), node.emergencies]].filter(([, count]) => count);
  return el("li", { class: node.ok ? "ok" : "bad", "data-testid": `node-${node.node}` },
    el("i", { class: "light", "aria-hidden": "true" }),
    el("span", {}, el("b", {}, node.names.join(", ")), " ", t("node {node}, {state}", node)),
    el("small", {}, t("{count} received", { count: number(node.received) }), ...faults.map(([word, count]) => el("em", {}, `, ${number(count)} ${word}`))));
}
