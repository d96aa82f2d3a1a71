// The view of the floor: the plan and, beside it, what the bus says.

import { $, el, row } from "./dom.js";
import { deg, mm, number, wrap } from "./units.js";
import { ESTIMATES, Plan, best } from "./plan.js";
import { on } from "./stream.js";

const OFTEN = 250; // [ms] between two updates of the numbers; eyes want no more
let plan;
let vehicle = null;
let told = 0;

export function setUpFloor() {
  plan = new Plan($("plan"));
  plan.view.listen();
  $("zoom-in").addEventListener("click", () => plan.view.zoom(1.4));
  $("zoom-out").addEventListener("click", () => plan.view.zoom(1 / 1.4));
  $("fit").addEventListener("click", () => plan.view.release());
  $("clear").addEventListener("click", () => plan.forget());
  $("legend").append(...Object.entries(ESTIMATES).map(([name, { label }]) => legendEntry(name, label)),
    el("li", {}, el("i", { class: "stroke sigma" }), "2 sigma"));
  on("state", show);
  on("nodes", ({ nodes }) => $("nodes").replaceChildren(...nodes.map(nodeLamp)));
}

export function showVehicle(given) {
  vehicle = plan.vehicle = given;
  plan.redraw();
}

/** The square of the session that drives, or none. */
export function showSquare(square) {
  plan.square = square;
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
  plan.show(state);
  if ($("floor").hidden || performance.now() - told < OFTEN) return;
  told = performance.now();
  if (state.plain) {
    showPoses(state);
    showCorrections(state);
  }
}

function showPoses(state) {
  const line = (name, { x, y, theta }, digits) => row(el("th", { scope: "row" }, name), mm(x, digits), mm(y, digits), deg(theta, 1 + digits));
  const given = Object.entries({ plain: "plain", ipec: "IPEC", filter: "filter" }).filter(([name]) => state[name]);
  $("where").replaceChildren(
    ...given.map(([name, word]) => line(el("span", { class: `ofkind ${name}` }, word), state[name], 0)),
    ...(state.sigma ? [line("± sigma", state.sigma, 1)] : []),
  );
  const { x, y, theta } = best(state);
  const { plain } = state;
  $("off").textContent = given.length > 1
    ? `Plain odometry is off by ${mm(Math.hypot(plain.x - x, plain.y - y))} mm and ${deg(Math.abs(wrap(plain.theta - theta)), 1)}°.`
    : "";
  $("plan").setAttribute("aria-label", `Floor plan; truck a at x ${mm(x)} mm, y ${mm(y)} mm, heading ${deg(theta, 0)}°`);
}

function showCorrections({ corrections, lost, joints, wheels }) {
  const pairs = [];
  for (const [truck, angle] of Object.entries(corrections ?? {})) pairs.push([`heading of truck ${truck}`, `${deg(angle, 3)}°`]);
  for (const [wheel, travel] of Object.entries(lost ?? {})) pairs.push([`${wheel} rolled in vain`, `${mm(travel, 1)} mm`]);
  if (joints) pairs.push(["joints a, b", `${deg(joints.a, 1)}°, ${deg(joints.b, 1)}°`], ["link", `${mm(joints.length, 1)} mm`]);
  if (wheels?.length) pairs.push(["wheels", `${wheels.map((speed, index) => mm(speed * radius(index))).join(", ")} mm/s`]);
  $("corrections").replaceChildren(...pairs.flatMap(([name, value]) => [el("dt", {}, name), el("dd", {}, value)]));
}

/** Of the wheel at a place in `wheels`: left and right of a, then of b [m]. */
function radius(index) {
  const truck = vehicle?.trucks[index < 2 ? "a" : "b"];
  return truck ? truck[index % 2 ? "wheel_diameter_right" : "wheel_diameter_left"] / 2 : NaN;
}

function nodeLamp(node) {
  const faults = [["missing", node.missing], ["restarts", node.restarts], ["emergencies", node.emergencies]].filter(([, count]) => count);
  return el("li", { class: node.ok ? "ok" : "bad", "data-testid": `node-${node.node}` },
    el("i", { class: "light", "aria-hidden": "true" }),
    el("span", {}, el("b", {}, node.names.join(", ")), ` node ${node.node}, ${node.state}`),
    el("small", {}, `${number(node.received)} received`, ...faults.map(([word, count]) => el("em", {}, `, ${number(count)} ${word}`))));
}
