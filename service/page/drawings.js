// Explaining drawings: the square in both directions, and the corner with the three distances.

import { svg } from "./dom.js";
import { t } from "./language.js";

/** The square as it is driven, cw or ccw, beginning at the walls. */
export function squareDrawing(direction) {
  const cw = direction === "cw";
  const [near, far] = cw ? [26, 114] : [114, 26];
  const corners = [[30, near], [118, near], [118, far], [30, far]];
  const legs = corners.map(([x, y], index) => {
    const [nx, ny] = corners[(index + 1) % 4];
    const along = (share) => [x + share * (nx - x), y + share * (ny - y)];
    const [bx, by] = along(0.5);
    const turn = (Math.atan2(ny - y, nx - x) * 180) / Math.PI;
    const inward = [74 - bx, 70 - by].map((distance) => Math.sign(Math.abs(distance) < 1 ? 0 : distance) * 15);
    return [
      svg("path", { class: "leg", d: `M${x} ${y}L${nx} ${ny}` }),
      svg("path", { class: "arrow", d: "M-5 -5L4 0L-5 5", transform: `translate(${bx} ${by}) rotate(${turn})` }),
      svg("text", { x: bx + inward[0], y: by + inward[1] + 4, class: "count" }, String(index + 1)),
    ];
  });
  return svg("svg", { viewBox: "0 0 140 150", class: `square ${direction}`, role: "img", "aria-label": cw ? t("A square driven clockwise") : t("A square driven counter-clockwise") },
    svg("path", { class: "wall", d: "M8 6V134" }),
    svg("path", { class: "wall", d: cw ? "M8 6H134" : "M8 134H134" }),
    ...legs.flat(),
    svg("g", { transform: `translate(30 ${near})` },
      svg("rect", { class: "deck", x: -9, y: -7, width: 18, height: 14, rx: 2 }),
      svg("path", { class: "wheels", d: "M-5 -8H5M-5 8H5" }),
      svg("path", { class: "arrow", d: "M3 -3L7 0L3 3" })),
    svg("text", { x: 74, y: 148, class: "name" }, cw ? "cw" : "ccw"));
}

/** The L-shaped corner, U section V: two sensors look right at the long wall, one looks back at the short one. */
export function cornerDrawing() {
  const range = (x, y, x2, y2, name, lx, ly, anchor) => [
    svg("path", { class: "range", d: `M${x} ${y}L${x2} ${y2}` }),
    svg("text", { x: lx, y: ly, "text-anchor": anchor, class: "label" }, name),
  ];
  return svg("svg", { viewBox: "0 0 320 150", role: "img", "aria-label": t("Right front and right rear are the distances to the long wall, behind is the distance to the short wall") },
    svg("path", { class: "wall", d: "M30 6V136H314" }),
    svg("g", {},
      svg("rect", { class: "deck", x: 128, y: 24, width: 92, height: 52, rx: 6 }),
      svg("path", { class: "wheels", d: "M160 20H188M160 80H188" }),
      svg("path", { class: "arrow", d: "M206 42L214 50L206 58" })),
    range(208, 76, 208, 134, t("right front"), 215, 112, "start"),
    range(140, 76, 140, 134, t("right rear"), 133, 112, "end"),
    range(128, 50, 32, 50, t("behind"), 80, 43, "middle"));
}
