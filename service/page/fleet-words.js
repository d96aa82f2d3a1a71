// What a daily report says of robots and places, as sentences in the page's language. English ones are those of the service's `says`.

import { componentName, effectName } from "./effect-words.js";
import { t } from "./language.js";
import { deg, mm, number } from "./units.js";

export const NORMAL = 1.96; // of an interval that holds 95 %
const UNITS = { 1: [100, "%"], rad: [180 / Math.PI, "°"] };
const RATIOS = { "left wheel": t("left wheel"), "right wheel": t("right wheel"), wheelbase: t("wheelbase") };

/** The factor and the unit by which a number of a robot is shown. */
export const shownIn = (unit) => UNITS[unit];

/** The name of a number of a robot. */
export const numberName = (name) => RATIOS[name] ?? componentName(name);

/** Why a robot is faulty or drifts; empty where nothing stands out. */
export function robotSays({ state, change, asked }) {
  if (asked) return t("triage asks for the same diagnosis since {since}: {effect} of {component}", { since: asked.since, effect: effectName(asked.effect), component: componentName(asked.component) });
  return change && state !== "fine" ? changeSays(change) : "";
}

function changeSays({ name, since, earliest, latest, shape, size, sigma, per_day: rate }) {
  const [factor, unit] = UNITS[name in RATIOS ? 1 : "rad"];
  const signed = (value) => number(factor * value, 3, "exceptZero");
  const onset = earliest === latest ? since : t("{since} ({earliest} to {latest})", { since, earliest, latest });
  return t("{name} changed by {size} ± {half} {unit} since {onset}", { name: numberName(name), size: signed(size), half: number(NORMAL * factor * sigma, 3), unit, onset })
    + (shape === "ramp" ? t(", {rate} {unit} a day", { rate: signed(rate), unit }) : "");
}

export function placeSays({ floor, effect, x, y, size, per_crossing: crossing, crossings }) {
  const what = effect === "loss" ? t("travel is lost") : t("robots creep to {angle} degrees", { angle: deg(Math.atan2(size[1], size[0]), 0) });
  return (floor ? t("floor {floor}, ", { floor }) : "")
    + t("at x {x} m, y {y} m: {what}, {lost} mm in a crossing, {crossings} crossings", { x: number(x, 2), y: number(y, 2), what, lost: mm(crossing, 1), crossings });
}
