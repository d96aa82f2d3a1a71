// Layers of the floor plan: the grid in metres, the square that is driven, and sigma.

import { t } from "./language.js";
import { number } from "./units.js";

/** Grid lines and their coordinates in metres. */
export function drawGrid(context, viewport, colours) {
  const step = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50].find((length) => length * viewport.scale > 44) ?? 100;
  const digits = step < 0.1 ? 2 : step < 1 ? 1 : 0;
  const [halfWide, halfHigh] = [viewport.width / 2 / viewport.scale, viewport.height / 2 / viewport.scale];
  context.font = "11px system-ui, sans-serif";
  context.textBaseline = "alphabetic";
  const lines = (middle, half, draw) => {
    for (let n = Math.ceil((middle - half) / step); n * step <= middle + half; n += 1) {
      context.strokeStyle = n === 0 ? colours.soft : colours.line;
      context.lineWidth = n === 0 ? 1.2 : 1;
      context.beginPath();
      draw(n * step);
      context.stroke();
    }
  };
  context.fillStyle = colours.soft;
  context.textAlign = "left";
  lines(viewport.x, halfWide, (x) => {
    const px = Math.round(viewport.at(x, 0)[0]) + 0.5;
    context.moveTo(px, 0);
    context.lineTo(px, viewport.height);
    if (px > 34 && px < viewport.width - 90) context.fillText(number(x, digits), px + 3, viewport.height - 5);
  });
  lines(viewport.y, halfHigh, (y) => {
    const py = Math.round(viewport.at(0, y)[1]) + 0.5;
    context.moveTo(0, py);
    context.lineTo(viewport.width, py);
    if (py > 14 && py < viewport.height - 22) context.fillText(number(y, digits), 5, py - 3);
  });
  context.textAlign = "right";
  context.fillText(t("x, y in m"), viewport.width - 6, viewport.height - 5);
}

/** The square that is driven. */
export function drawSquare(context, viewport, { side, direction }, colours) {
  const across = direction === "cw" ? -side : side;
  context.beginPath();
  for (const [x, y] of [[0, 0], [side, 0], [side, across], [0, across]]) context.lineTo(...viewport.at(x, y));
  context.closePath();
  Object.assign(context, { strokeStyle: colours.soft, lineWidth: 1.2, globalAlpha: 0.8 });
  context.setLineDash([2, 4]);
  context.stroke();
  context.setLineDash([]);
  context.globalAlpha = 1;
}

/** Two sigma in position as an ellipse, in heading as a wedge. */
export function drawSigma(context, viewport, pose, sigma, colours) {
  const [x, y] = viewport.at(pose.x, pose.y);
  const wide = 2 * (sigma.theta ?? 0);
  Object.assign(context, { fillStyle: colours.sigma, strokeStyle: colours.filter, lineWidth: 1.4 });
  context.globalAlpha = 0.35;
  context.beginPath();
  context.moveTo(x, y);
  context.arc(x, y, Math.max(30, 0.5 * viewport.scale), -pose.theta - wide, -pose.theta + wide);
  context.closePath();
  context.fill();
  context.globalAlpha = 1;
  context.beginPath();
  context.ellipse(x, y, Math.max(2, 2 * sigma.x * viewport.scale), Math.max(2, 2 * sigma.y * viewport.scale), 0, 0, 2 * Math.PI);
  context.stroke();
}
