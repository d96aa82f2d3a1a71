// The floor of a fleet with its bad places, and a robot's number day by day.

import { svg } from "./dom.js";
import { NORMAL, numberName, placeSays, shownIn } from "./fleet-words.js";
import { t } from "./language.js";
import { mm, niceStep, number } from "./units.js";

const TWO_SIGMA = 2.448; // of an ellipse that holds a place with 95 %: the square root of chi-square's, 2 degrees
const SHADES = 4; // of cells by how often they were driven over
const DAY = 86400000; // [ms]

/** The floor [m]: where robots drove, and its bad places with the ellipse that holds each with 95 %. */
export function floorMap({ cell, driven, places }) {
  const xs = [...driven.map(([x]) => x), ...places.map(({ x }) => x)];
  const ys = [...driven.map(([, y]) => y), ...places.map(({ y }) => y)];
  const [left, right, bottom, top] = [extreme(xs, Math.min) - 1, extreme(xs, Math.max) + 1, extreme(ys, Math.min) - 1, extreme(ys, Math.max) + 1];
  const most = Math.sqrt(extreme(driven.map(([, , count]) => count), Math.max));
  const shades = Array.from({ length: SHADES }, () => []);
  for (const [x, y, count] of driven) {
    const shade = Math.min(SHADES - 1, Math.floor((SHADES * Math.sqrt(count)) / most));
    shades[shade].push(`M${x - cell / 2} ${-y - cell / 2}h${cell}v${cell}h${-cell}z`);
  }
  const step = niceStep((right - left) / 3);
  const words = places.map(placeSays).join("; ") || t("no bad place");
  const letter = (right - left) / 42;
  return svg("svg", { viewBox: `${left} ${-top} ${right - left} ${top - bottom}`, role: "img", "aria-label": t("The floor: {places}", { places: words }), "data-testid": "floor-map" },
    shades.map((paths, shade) => svg("path", { class: `driven shade${shade}`, d: paths.join("") })),
    scale(left, bottom, step, letter),
    places.map((place, index) => placeMark(place, letter, index)));
}

/** A bar of some metres, in the corner of the map. */
function scale(left, bottom, step, letter) {
  const [x, y] = [left + letter, -bottom - letter];
  return svg("g", { class: "scale", "stroke-width": letter / 7 },
    svg("path", { d: `M${x} ${y}h${step}` }),
    svg("text", { x: x + step + letter / 2, y: y + letter / 3, "font-size": letter }, `${number(step)} m`));
}

function placeMark(place, letter, index) {
  const { effect, x, y, reach, covariance, size, per_crossing: way } = place;
  const [[xx, xy], [, yy]] = covariance;
  const [mean, half] = [(xx + yy) / 2, Math.hypot((xx - yy) / 2, xy)];
  const angle = (Math.atan2(2 * xy, xx - yy) / 2) * (180 / Math.PI);
  const tip = effect === "creep" ? [(1.6 * reach * size[0]) / Math.hypot(...size), (1.6 * reach * size[1]) / Math.hypot(...size)] : null;
  return svg("g", { class: `place ${effect}`, "data-testid": `place-${index}` },
    svg("title", {}, placeSays(place)),
    svg("circle", { cx: x, cy: -y, r: reach }),
    svg("ellipse", { cx: x, cy: -y, rx: TWO_SIGMA * Math.sqrt(mean + half), ry: TWO_SIGMA * Math.sqrt(Math.max(0, mean - half)), transform: `rotate(${-angle} ${x} ${-y})`, "stroke-width": letter / 9 }),
    tip ? svg("path", { class: "creep-arrow", d: arrow(x, y, tip), "stroke-width": letter / 5 }) : null,
    svg("text", { x: x + reach + letter / 2, y: -y - reach / 2, "font-size": letter }, `${mm(way, 1)} mm`));
}

function arrow(x, y, [dx, dy]) {
  const head = (turn) => [x + 0.7 * dx - turn * 0.3 * dy, -(y + 0.7 * dy + turn * 0.3 * dx)].join(" ");
  return `M${x} ${-y}L${x + dx} ${-(y + dy)}M${head(1)}L${x + dx} ${-(y + dy)}L${head(-1)}`;
}

const BOX = { width: 460, height: 200, left: 52, right: 10, top: 10, bottom: 26 };

/** A robot's number day by day with its 95 % intervals; `since` is the date since which it changed, or null. */
export function historyPlot({ name, unit, days, value, sigma }, since) {
  const [factor, word] = shownIn(unit);
  const times = days.map((day) => Date.parse(day) / DAY);
  const points = value.map((each, index) => [times[index], factor * each, NORMAL * factor * sigma[index]]);
  const first = times[0];
  const last = Math.max(times.at(-1), first + 1);
  const low = Math.min(0, extreme(points.map(([, y, half]) => y - half), Math.min));
  const high = Math.max(0, extreme(points.map(([, y, half]) => y + half), Math.max));
  const pad = 0.06 * (high - low || 1);
  const { width, height, left, right, top, bottom } = BOX;
  const at = (time, y) => [left + ((time - first + 0.5) / (last - first + 1)) * (width - left - right), top + ((high + pad - y) / (high - low + 2 * pad)) * (height - top - bottom)];
  const label = t("{name} [{unit}] of {days} days, last {value} {unit}", { name: numberName(name), unit: word, days: days.length, value: number(points.at(-1)[1], 3) }) + (since ? t(", changed since {day}", { day: since }) : "");
  return svg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": label, "data-testid": `history-${name.replaceAll(" ", "-")}` },
    ticks(low - pad, high + pad).map((tick) => {
      const [, y] = at(first, tick);
      return [svg("path", { class: tick === 0 ? "axis" : "grid", d: `M${left} ${y}H${width - right}` }), svg("text", { class: "tick", x: left - 6, y: y + 4, "text-anchor": "end" }, `${number(tick, digitsOf(high - low + 2 * pad))}`)];
    }),
    svg("text", { class: "tick", x: left + 4, y: top + 8 }, word),
    dateTicks(days).map(([day, anchor]) => svg("text", { class: "tick", x: at(Date.parse(day) / DAY, 0)[0], y: height - 8, "text-anchor": anchor }, day)),
    since ? svg("path", { class: "since", d: `M${at(Date.parse(since) / DAY - 0.5, 0)[0]} ${top}V${height - bottom}` }) : null,
    points.map(([time, y, half], index) => {
      const [x, middle] = at(time, y);
      return svg("g", { class: "point" }, svg("title", {}, `${days[index]}: ${number(y, 3)} ± ${number(half, 3)} ${word}`), svg("path", { d: `M${x} ${at(time, y - half)[1]}V${at(time, y + half)[1]}` }), svg("circle", { cx: x, cy: middle, r: 3.2 }));
    }));
}

function dateTicks(days) {
  return days.length > 1 ? [[days[0], "start"], [days.at(-1), "end"]] : [[days[0], "middle"]];
}

function ticks(low, high) {
  const step = niceStep((high - low) / 3);
  return Array.from({ length: Math.floor(high / step) - Math.ceil(low / step) + 1 }, (_, index) => (Math.ceil(low / step) + index) * step).map((tick) => (Math.abs(tick) < step / 2 ? 0 : tick));
}

const digitsOf = (range) => Math.max(0, -Math.floor(Math.log10(niceStep(range / 3))));

const extreme = (values, choose) => values.reduce((a, b) => choose(a, b));
