// The result of a UMBmark session: all methods side by side, advice, the plot, and the button that accepts it.

import { call } from "./api.js";
import { $, actionButton, el, row } from "./dom.js";
import { drawing } from "./embedded-documents.js";
import { t } from "./language.js";
import { number, size } from "./units.js";

const METHODS = {
  "printed-x": t("printed, from x"), "printed-y": t("printed, from y"), printed: t("printed, x and y"), "printed-true-b": t("printed, true b"),
  heading: t("headings alone"), exact: t("exact chain"), weighted: t("exact, weighted"),
};
const SEVERITIES = { note: t("Note"), warning: t("Warning"), error: t("Error") };
let shown = ""; // session and revision
let session = null;

export function clearResult() {
  shown = "";
  session = null;
  $("result").hidden = true;
  $("result").replaceChildren();
}

/** Show the session's result; `changed` is called when it was accepted. */
export async function showResult(solved, changed) {
  const answer = await call("GET", `/v1/umbmark/sessions/${solved.id}/result`);
  const [result, tag] = [await answer.json(), answer.headers.get("ETag") ?? "*"];
  const key = `${solved.id} ${result.revision} ${solved.state}`;
  if (key === shown) return;
  [shown, session] = [key, solved];
  const plot = el("figure", { class: "card plot", id: "plot" });
  $("result").replaceChildren(
    ...Object.entries(result.trucks).map(([truck, calibration]) => truckCard(truck, calibration, result.method)),
    plot,
    solved.possible.includes("accept") ? acceptCard(result, tag, changed) : "",
  );
  $("result").hidden = false;
  await showPlot();
}

async function showPlot() {
  const holder = $("plot");
  try {
    const answer = await call("GET", `/v1/umbmark/sessions/${session.id}/plot.svg`);
    const picture = drawing(await answer.text());
    picture.setAttribute("role", "img");
    picture.setAttribute("aria-label", t("Return errors before and after calibration"));
    holder.replaceChildren(picture, el("figcaption", {}, t("Return errors before and, as calculated, after calibration")));
  } catch (problem) {
    holder.replaceChildren(el("p", { class: "message", "data-kind": "wrong" }, problem.message));
  }
}

function truckCard(truck, { errors, methods, advice, second_pass: pass, nominal, calibrated }, chosen) {
  const better = errors.after > 0 ? errors.e_max_syst / errors.after : Infinity;
  return el("section", { class: "card", "data-testid": `result-${truck}`, "aria-label": t("Result of truck {truck}", { truck }) },
    el("h2", {}, t("Truck {truck}", { truck })),
    el("div", { class: "headline" },
      figure(t("Largest systematic error"), `${size(errors.e_max_syst)} → ${size(errors.after)}`, Number.isFinite(better) ? t("{factor} times better", { factor: number(better, better < 10 ? 1 : 0) }) : ""),
      figure(t("Wheelbase"), `${fine(calibrated.wheelbase)} mm`, change(nominal.wheelbase, calibrated.wheelbase)),
      figure(t("Left wheel"), `${fine(calibrated.wheel_diameter_left, 3)} mm`, change(nominal.wheel_diameter_left, calibrated.wheel_diameter_left, 3)),
      figure(t("Right wheel"), `${fine(calibrated.wheel_diameter_right, 3)} mm`, change(nominal.wheel_diameter_right, calibrated.wheel_diameter_right, 3))),
    ...advice.map(({ severity, what, do: todo }) => el("p", { class: `advice ${severity}` }, el("b", {}, `${SEVERITIES[severity]}: `), `${what}: ${todo}`)),
    el("p", { class: "soft" }, `${pass}.`),
    el("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": t("Methods") }, el("table", { class: "numbers methods" },
      el("caption", {}, t("All methods, with 95 % confidence")),
      el("thead", {}, row(...[t("method"), factor("b"), factor("d"), t("wheelbase mm"), t("left mm"), t("right mm"), t("c left"), t("c right"), t("error after mm")].map((word) => el("th", { scope: "col" }, word)))),
      el("tbody", {}, methods.map((calibration) => methodRow(calibration, calibration.method === chosen))))));
}

function figure(label, value, under) {
  return el("div", {}, el("span", {}, label), el("strong", {}, value), el("small", {}, under));
}

function methodRow(calibration, chosen) {
  const line = row(
    el("th", { scope: "row" }, METHODS[calibration.method] ?? calibration.method, chosen ? el("span", { class: "chip solved" }, t("used")) : null),
    limits(calibration.e_b, 1, 5), limits(calibration.e_d, 1, 5),
    limits(calibration.wheelbase, 1000, 2), limits(calibration.diameter_left, 1000, 3), limits(calibration.diameter_right, 1000, 3),
    number(calibration.c_left, 5), number(calibration.c_right, 5), number(1000 * calibration.after, 1),
  );
  if (chosen) line.className = "chosen";
  return line;
}

function limits({ value, low, high }, factor, digits) {
  const text = number(factor * value, digits);
  return low == null ? text : el("span", {}, text, el("small", {}, t("{low} to {high}", { low: number(factor * low, digits), high: number(factor * high, digits) })));
}

const factor = (letter) => el("span", {}, "E", el("sub", {}, letter));
const fine = (length, digits = 2) => number(1000 * length, digits);
const change = (before, after, digits = 2) => t("was {before}, {change}", { before: fine(before, digits), change: number(1000 * (after - before), digits, "exceptZero") });

function acceptCard({ usable, vehicle }, tag, changed) {
  const message = el("p", { class: "message", id: "accept-message", role: "alert" });
  const force = el("input", { type: "checkbox", id: "force" });
  const button = actionButton(t("Accept"), message, async () => {
    try {
      await call("POST", `/v1/umbmark/sessions/${session.id}/accept`, { body: force.checked ? { force: true } : {}, headers: { "If-Match": tag } });
    } finally {
      shown = "";
    }
    await changed();
  }, { class: "primary", id: "accept" });
  return el("section", { class: "card accept", "aria-label": t("Accept") },
    el("p", {}, el("b", {}, t("Accept these parameters for {vehicle}?", { vehicle })), " ", t("They become its newest version; the former versions stay.")),
    usable ? null : el("label", { class: "check" }, force, t("although a check reports an error (see advice)")),
    el("div", { class: "buttons" }, button), message);
}
