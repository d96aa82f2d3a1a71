// A canvas that shows a part of the floor: pan, zoom, fit; by mouse, touch or keys.

const CLOSEST = 4000; // [px/m]
const FARTHEST = 2;
const STEP = 1.25;
const BUTTONS_HEIGHT = 24; // [px] that the buttons above the plan take

export class Viewport {
  /** `redraw` is called whenever another part is shown. `free` is true once the user has moved the viewport. */
  constructor(canvas, redraw) {
    this.canvas = canvas;
    this.redraw = redraw;
    this.scale = 90;
    this.x = 0;
    this.y = 0;
    this.free = false;
    this.pointers = new Map();
    new ResizeObserver(() => this.#resize()).observe(canvas);
  }

  /** Let the user move it. */
  listen() {
    const on = (kind, listener, options) => this.canvas.addEventListener(kind, listener, options);
    on("pointerdown", (event) => this.#down(event));
    on("pointermove", (event) => this.#move(event));
    for (const kind of ["pointerup", "pointercancel"]) on(kind, (event) => this.pointers.delete(event.pointerId));
    on("wheel", (event) => {
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), event.offsetX, event.offsetY);
    }, { passive: false });
    on("keydown", (event) => this.#key(event));
  }

  get width() { return this.canvas.clientWidth; }
  get height() { return this.canvas.clientHeight; }

  /** Where a point of the floor [m] stands on the canvas [px]. */
  at(x, y) {
    return [this.width / 2 + (x - this.x) * this.scale, this.height / 2 - (y - this.y) * this.scale];
  }

  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const scale = Math.min(CLOSEST, Math.max(FARTHEST, this.scale * factor));
    const [dx, dy] = [px - this.width / 2, py - this.height / 2];
    this.x += dx / this.scale - dx / scale;
    this.y -= dy / this.scale - dy / scale;
    this.scale = scale;
    this.free = true;
    this.redraw();
  }

  pan(dx, dy) {
    this.x -= dx / this.scale;
    this.y += dy / this.scale;
    this.free = true;
    this.redraw();
  }

  /** Show all of a part of the floor: [left, bottom, right, top] in metres. */
  fit([left, bottom, right, top], margin = 36) {
    const room = (pixels) => Math.max(40, pixels - 2 * margin);
    this.scale = Math.min(room(this.width) / (right - left), room(this.height - BUTTONS_HEIGHT) / (top - bottom), 300);
    this.x = (left + right) / 2;
    this.y = (bottom + top) / 2 + BUTTONS_HEIGHT / 2 / this.scale;
  }

  #resize() {
    const ratio = devicePixelRatio || 1;
    this.canvas.width = Math.round(this.width * ratio);
    this.canvas.height = Math.round(this.height * ratio);
    this.redraw();
  }

  #down(event) {
    this.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
  }

  #move(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const now = [event.offsetX, event.offsetY];
    const other = [...this.pointers].find(([id]) => id !== event.pointerId)?.[1];
    this.pointers.set(event.pointerId, now);
    if (other) this.zoom(distance(now, other) / distance(before, other), ...other);
    else this.pan(now[0] - before[0], now[1] - before[1]);
  }

  #key(event) {
    const moves = { ArrowLeft: [50, 0], ArrowRight: [-50, 0], ArrowUp: [0, 50], ArrowDown: [0, -50] };
    if (event.key in moves) this.pan(...moves[event.key]);
    else if (event.key === "+" || event.key === "=") this.zoom(STEP);
    else if (event.key === "-") this.zoom(1 / STEP);
    else if (event.key === "0") this.release();
    else return;
    event.preventDefault();
  }

  /** Back to showing everything. */
  release() {
    this.free = false;
    this.redraw();
  }
}

const distance = (a, b) => Math.max(1, Math.hypot(a[0] - b[0], a[1] - b[1]));
