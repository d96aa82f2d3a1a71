// Return positions as in figure 6 of the UMBmark paper: circles cw, squares ccw, centres of gravity, E_max,syst.

import { svg } from "./dom.js";
import { t } from "./language.js";
import { deg, mm, niceStep, size } from "./units.js";

const BOX = 400;
const HALF = BOX / 2;
const EDGE = 178; // of the drawing, from its middle

/** Centre of gravity of each direction, and E_max,syst, U (3.2)-(3.4) [m]. */
export function sums(samples, truck) {
  const centres = {};
  for (const direction of ["cw", "ccw"]) {
    const runs = samples.filter((sample) => sample.direction === direction && sample.errors[truck]).map((sample) => sample.errors[truck]);
    if (runs.length) centres[direction] = { x: mean(runs.map(({ x }) => x)), y: mean(runs.map(({ y }) => y)), runs: runs.length };
  }
  return { centres, largest: Math.max(0, ...Object.values(centres).map(({ x, y }) => Math.hypot(x, y))) };
}

/** How far a drawing must reach that holds the runs of all trucks [m]. */
export function reach(samples) {
  const lengths = samples.flatMap(({ errors }) => Object.values(errors).map(({ x, y }) => Math.hypot(x, y)));
  return 1.12 * Math.max(0.01, ...lengths);
}

/** The return errors of one truck; `edge` is how far the drawing reaches [m]. */
export function clusterDrawing(samples, truck, edge) {
  const runs = samples.filter((sample) => sample.errors[truck]);
  const { centres, largest } = sums(samples, truck);
  const at = (x, y) => [HALF + (x / edge) * EDGE, HALF - (y / edge) * EDGE];
  const middles = Object.entries(centres).map(([direction, { x, y }]) => [direction, at(x, y)]);
  const both = middles.length === 2;
  return svg("svg", { viewBox: `0 0 ${BOX} ${BOX}`, role: "img", "data-testid": `clusters-${truck}`, "aria-label": describe(truck, centres, largest) },
    both ? svg("circle", { class: "ring", cx: HALF, cy: HALF, r: (largest / edge) * EDGE }) : null,
    axes(edge),
    ...middles.map(([direction, [x, y]]) => svg("path", { class: `spoke ${direction}`, d: `M${HALF} ${HALF}L${x} ${y}` })),
    ...runs.map((sample) => point(sample, sample.errors[truck], at)),
    ...middles.map(([, [x, y]]) => svg("path", { class: "cross", d: `M${x - 10} ${y}h20M${x} ${y - 10}v20` })));
}

function axes(edge) {
  const step = niceStep(edge / 2); // two to five ticks on each side
  const parts = [];
  for (let tick = step; tick < edge; tick += step) {
    for (const value of [tick, -tick]) {
      const away = (value / edge) * EDGE;
      parts.push(svg("path", { class: "grid", d: `M${HALF + away} ${HALF - EDGE}v${2 * EDGE}M${HALF - EDGE} ${HALF - away}h${2 * EDGE}` }));
      parts.push(svg("text", { class: "tick", x: HALF + away, y: HALF + 13, "text-anchor": "middle" }, mm(value)));
      parts.push(svg("text", { class: "tick", x: HALF - 5, y: HALF - away + 4, "text-anchor": "end" }, mm(value)));
    }
  }
  return svg("g", {}, ...parts,
    svg("path", { class: "axis", d: `M${HALF - EDGE} ${HALF}h${2 * EDGE}M${HALF} ${HALF - EDGE}v${2 * EDGE}` }),
    svg("text", { class: "tick", x: HALF + EDGE, y: HALF - 6, "text-anchor": "end" }, "x mm"),
    svg("text", { class: "tick", x: HALF + 6, y: HALF - EDGE + 8 }, "y mm"));
}

function point({ number: run, direction }, error, at) {
  const [x, y] = at(error.x, error.y);
  const title = svg("title", {}, `${t("run {run}, {direction}", { run, direction })}: ${mm(error.x)} mm, ${mm(error.y)} mm${error.theta == null ? "" : `, ${deg(error.theta)}°`}`);
  return direction === "cw"
    ? svg("circle", { class: "run cw", "data-run": run, cx: x, cy: y, r: 5.5 }, title)
    : svg("rect", { class: "run ccw", "data-run": run, x: x - 5, y: y - 5, width: 10, height: 10 }, title);
}

function describe(truck, centres, largest) {
  const words = Object.entries(centres).map(([direction, { x, y, runs }]) => t("{runs} runs {direction} with their centre at {x}, {y} mm", { runs, direction, x: mm(x), y: mm(y) }));
  return words.length ? t("Return errors of truck {truck}: {clusters}; largest distance {largest}", { truck, clusters: words.join("; "), largest: size(largest) }) : t("No runs of truck {truck} yet", { truck });
}

const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
