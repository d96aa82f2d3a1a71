// The floor plan: its layers, trajectories and the robot, on a canvas.

import { colour } from "./dom.js";
import { t } from "./language.js";
import { drawGrid, drawSigma, drawSquare } from "./plan-layers.js";
import { stretch, Trajectory } from "./trajectory.js";
import { drawRobot, follower } from "./truck.js";
import { Viewport } from "./viewport.js";

export const ESTIMATES = {
  plain: { label: t("plain odometry"), width: 2, dash: [7, 5] },
  ipec: { label: "IPEC", width: 2, dash: [] },
  filter: { label: t("filter"), width: 3, dash: [] },
};
const COLOURS = ["ink", "soft", "line", "paper", "card", "deck", "link", "plain", "ipec", "filter", "sigma"];

/** The most accurate estimate that there is. */
export const best = (state) => state.filter ?? state.ipec ?? state.plain;

/** Where both trucks stand, by the best estimate. */
export function posesOf(state) {
  const a = best(state);
  return { a, b: state.follower ?? (state.joints ? follower(a, state.joints) : null) };
}

export class Plan {
  constructor(canvas) {
    this.canvas = canvas;
    this.viewport = new Viewport(canvas, () => this.redraw());
    this.trajectories = Object.fromEntries(Object.keys(ESTIMATES).map((name) => [name, new Trajectory()]));
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
    for (const [name, trajectory] of Object.entries(this.trajectories)) if (state[name]) trajectory.add(state[name]);
    this.redraw();
  }

  /** Begin another lap. */
  cut() {
    for (const trajectory of Object.values(this.trajectories)) trajectory.cut();
  }

  forget() {
    for (const trajectory of Object.values(this.trajectories)) trajectory.forget();
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
    if (!this.viewport.free) this.viewport.fit(this.#box());
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, this.viewport.width, this.viewport.height);
    drawGrid(context, this.viewport, colours);
    if (this.square) drawSquare(context, this.viewport, this.square, colours);
    for (const [name, { width, dash }] of Object.entries(ESTIMATES)) {
      if (this.hidden.has(name)) continue;
      Object.assign(context, { strokeStyle: colours[name], lineWidth: width, lineJoin: "round", lineCap: "round" });
      context.setLineDash(dash);
      this.trajectories[name].draw(context, this.viewport);
    }
    context.setLineDash([]);
    if (!this.state?.plain) return;
    const poses = posesOf(this.state);
    if (this.vehicle) drawRobot(context, this.viewport, this.vehicle, poses, colours);
    if (this.state.sigma) drawSigma(context, this.viewport, poses.a, this.state.sigma, colours);
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
    stretch(box, points);
    for (const trajectory of Object.values(this.trajectories)) trajectory.stretch(box);
    return box;
  }
}
