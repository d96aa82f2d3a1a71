// The trajectory of an estimate: a segment for each lap, thinned out.

const NEAR = 0.015; // [m]: points closer than that say nothing
const FAR = 0.3; // [m]: between such points a fast simulation may have turned a corner
const LAPS = 12;
const POINTS = 3000; // of one segment

export class Trajectory {
  constructor() {
    this.forget();
  }

  forget() {
    this.segments = [[]];
  }

  /** Begin another lap. */
  cut() {
    if (this.#last.length) this.segments.push([]);
    if (this.segments.length > LAPS) this.segments.shift();
  }

  add({ x, y, theta }) {
    const segment = this.#last;
    const before = segment.at(-1);
    const gap = before ? Math.hypot(x - before[0], y - before[1]) : 0;
    if (before && gap < NEAR) {
      before[2] = theta;
      return;
    }
    const between = gap > FAR ? corner(before, [x, y, theta]) : null;
    segment.push(...(between ? [between] : []), [x, y, theta]);
    if (segment.length > POINTS) this.segments[this.segments.length - 1] = segment.filter((_, index) => index % 2 === 0);
  }

  get #last() {
    return this.segments.at(-1);
  }

  /** Stretch [left, bottom, right, top] so that it holds every point. */
  stretch(box) {
    for (const segment of this.segments) stretch(box, segment);
  }

  draw(context, viewport) {
    this.segments.forEach((segment, index) => {
      context.globalAlpha = index === this.segments.length - 1 ? 1 : 0.28;
      context.beginPath();
      for (const [x, y] of segment) context.lineTo(...viewport.at(x, y));
      context.stroke();
    });
    context.globalAlpha = 1;
  }
}

/** Stretch [left, bottom, right, top] so that it holds points. */
export function stretch(box, points) {
  for (const [x, y] of points) {
    box[0] = Math.min(box[0], x);
    box[1] = Math.min(box[1], y);
    box[2] = Math.max(box[2], x);
    box[3] = Math.max(box[3], y);
  }
}

/** Where a robot that turns on the spot must have turned: straight ahead of one pose and straight behind the other. */
function corner([x, y, before], [nx, ny, after]) {
  const turn = Math.sin(after - before);
  if (Math.abs(turn) < 0.3) return null;
  const [dx, dy] = [nx - x, ny - y];
  const ahead = (dx * Math.sin(after) - dy * Math.cos(after)) / turn;
  const behind = (dy * Math.cos(before) - dx * Math.sin(before)) / turn;
  return ahead > 0 && behind > 0 ? [x + ahead * Math.cos(before), y + ahead * Math.sin(before), after] : null;
}
