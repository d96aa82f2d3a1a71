// The floor plan: grid in metres, the square that is to be driven, trajectories, sigma, the robot.

import { colour } from "./dom.js";
import { number } from "./units.js";
import { Trail } from "./trail.js";
import { drawRobot, follower } from "./truck.js";
import { View } from "./view.js";

export const ESTIMATES = {
  plain: { label: "plain odometry", width: 2, dash: [7, 5] },
  ipec: { label: "IPEC", width: 2, dash: [] },
  filter: { label: "filter", width: 3, dash: [] },
};
const COLOURS = ["ink", "soft", "line", "paper", "card", "deck", "link", "plain", "ipec", "filter", "sigma"];

/** The estimate that is most to be believed. */
export const best = (state) => state.filter ?? state.ipec ?? state.plain;

/** Where both trucks stand, by the best estimate. */
export function posesOf(state) {
  const a = best(state);
  return { a, b: state.follower ?? (state.joints ? follower(a, state.joints) : null) };
}

export class Plan {
  constructor(canvas) {
    this.canvas = canvas;
    this.view = new View(canvas, () => this.redraw());
    this.trails = Object.fromEntries(Object.keys(ESTIMATES).map((name) => [name, new Trail()]));
    this.hidden = new Set();
    this.vehicle = null;
    this.square = null; // {side, direction}
    this.state = null;
    this.lap = null;
    document.addEventListener("theme", () => this.redraw());
  }

  show(state) {
    if (state.lap !== this.lap) this.cut();
    this.lap = state.lap;
    this.state = state;
    for (const [name, trail] of Object.entries(this.trails)) if (state[name]) trail.add(state[name]);
    this.redraw();
  }

  /** Another lap begins. */
  cut() {
    for (const trail of Object.values(this.trails)) trail.cut();
  }

  forget() {
    for (const trail of Object.values(this.trails)) trail.forget();
    this.redraw();
  }

  redraw() {
    if (this.waiting) return;
    this.waiting = requestAnimationFrame(() => {
      this.waiting = 0;
      if (this.canvas.clientWidth) this.#draw();
    });
  }

  #draw() {
    const context = this.canvas.getContext("2d");
    const ratio = devicePixelRatio || 1;
    const colours = Object.fromEntries(COLOURS.map((name) => [name, colour(name)]));
    if (!this.view.free) this.view.fit(this.#box());
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, this.view.width, this.view.height);
    drawGrid(context, this.view, colours);
    if (this.square) drawSquare(context, this.view, this.square, colours);
    for (const [name, { width, dash }] of Object.entries(ESTIMATES)) {
      if (this.hidden.has(name)) continue;
      Object.assign(context, { strokeStyle: colours[name], lineWidth: width, lineJoin: "round", lineCap: "round" });
      context.setLineDash(dash);
      this.trails[name].draw(context, this.view);
    }
    context.setLineDash([]);
    if (!this.state?.plain) return;
    const poses = posesOf(this.state);
    if (this.vehicle) drawRobot(context, this.view, this.vehicle, poses, colours);
    if (this.state.sigma) drawSigma(context, this.view, poses.a, this.state.sigma, colours);
  }

  /** What a fit shows: all trajectories, the square and the robot. */
  #box() {
    const box = [-0.7, -0.7, 0.7, 0.7];
    const around = (x, y, room) => [[x - room, y - room], [x + room, y + room]];
    const points = [];
    if (this.square) {
      const across = this.square.direction === "cw" ? -this.square.side : this.square.side;
      points.push([0, 0], [this.square.side, across]);
    }
    if (this.state?.plain) {
      const { a, b } = posesOf(this.state);
      points.push(...around(a.x, a.y, 0.35), ...(b ? around(b.x, b.y, 0.35) : []));
    }
    for (const [x, y] of points) {
      box[0] = Math.min(box[0], x);
      box[1] = Math.min(box[1], y);
      box[2] = Math.max(box[2], x);
      box[3] = Math.max(box[3], y);
    }
    for (const trail of Object.values(this.trails)) trail.stretch(box);
    return box;
  }
}

function drawGrid(context, view, colours) {
  const step = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50].find((one) => one * view.scale > 44) ?? 100;
  const digits = step < 0.1 ? 2 : step < 1 ? 1 : 0;
  const [halfWide, halfHigh] = [view.width / 2 / view.scale, view.height / 2 / view.scale];
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
  lines(view.x, halfWide, (x) => {
    const px = Math.round(view.at(x, 0)[0]) + 0.5;
    context.moveTo(px, 0);
    context.lineTo(px, view.height);
    if (px > 34 && px < view.width - 90) context.fillText(number(x, digits), px + 3, view.height - 5);
  });
  lines(view.y, halfHigh, (y) => {
    const py = Math.round(view.at(0, y)[1]) + 0.5;
    context.moveTo(0, py);
    context.lineTo(view.width, py);
    if (py > 14 && py < view.height - 22) context.fillText(number(y, digits), 5, py - 3);
  });
  context.textAlign = "right";
  context.fillText("x, y in m", view.width - 6, view.height - 5);
}

function drawSquare(context, view, { side, direction }, colours) {
  const across = direction === "cw" ? -side : side;
  context.beginPath();
  for (const [x, y] of [[0, 0], [side, 0], [side, across], [0, across]]) context.lineTo(...view.at(x, y));
  context.closePath();
  Object.assign(context, { strokeStyle: colours.soft, lineWidth: 1.2, globalAlpha: 0.8 });
  context.setLineDash([2, 4]);
  context.stroke();
  context.setLineDash([]);
  context.globalAlpha = 1;
}

/** Two sigma in position as an ellipse, in heading as a wedge. */
function drawSigma(context, view, pose, sigma, colours) {
  const [x, y] = view.at(pose.x, pose.y);
  const wide = 2 * (sigma.theta ?? 0);
  Object.assign(context, { fillStyle: colours.sigma, strokeStyle: colours.filter, lineWidth: 1.4 });
  context.globalAlpha = 0.35;
  context.beginPath();
  context.moveTo(x, y);
  context.arc(x, y, Math.max(30, 0.5 * view.scale), -pose.theta - wide, -pose.theta + wide);
  context.closePath();
  context.fill();
  context.globalAlpha = 1;
  context.beginPath();
  context.ellipse(x, y, Math.max(2, 2 * sigma.x * view.scale), Math.max(2, 2 * sigma.y * view.scale), 0, 0, 2 * Math.PI);
  context.stroke();
}
