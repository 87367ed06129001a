/**
 * One loop for drawings, which are redrawn only after changes, not while the page is hidden, and seldom while off-screen.
 *
 * Sizes are in CSS pixels; the canvas itself has the resolution of the screen.
 */

/** @typedef {Record<string, string>} Colours */
/** @typedef {(context: CanvasRenderingContext2D, width: number, height: number, colours: Colours, nowMs: number) =>
 *    boolean | void} Draw returns whether it is still moving */

const NAMES = [
  "ground", "plate", "body", "line", "faint", "ink", "muted", "high", "low", "open", "velocity", "position", "metal",
  "cursor-a", "cursor-b", "trigger", "accent",
]; // prettier-ignore
const FASTEST_MS = 30; // between two frames of a moving drawing
const EARLY_MS = 6; // by which a frame may be early
const LATE_MS = 12;
const UNSEEN_MS = 1000; // between two frames of an off-screen drawing

/** @type {Set<Moving>} */
const waiting = new Set();
/** @type {Set<Moving>} */
const all = new Set();
let frame = 0;
/** @type {ReturnType<typeof setTimeout> | undefined} */
let timer;
/** @type {Colours | null} */
let colours = null;

/**
 * Draw the waiting surfaces that are due.
 * @param {number} nowMs
 */
function draw(nowMs) {
  for (const surface of [...waiting]) {
    if (nowMs - surface.lastMs < surface.dueMs - EARLY_MS) continue;
    waiting.delete(surface);
    surface.lastMs = nowMs;
    surface.paint(nowMs);
  }
}

/** Request a frame when a visible surface is due: a frame takes time even if it draws nothing. */
function wake() {
  if (frame || document.hidden) return;
  let dueMs = Infinity;
  for (const surface of waiting) dueMs = Math.min(dueMs, surface.lastMs + surface.dueMs);
  if (dueMs === Infinity) return;
  const waitMs = dueMs - performance.now();
  clearTimeout(timer);
  // a view that arrives in time draws in its own frame, before this one
  if (waitMs > 0) timer = setTimeout(ask, waitMs + LATE_MS);
  else ask();
}

function ask() {
  clearTimeout(timer);
  if (frame || document.hidden) return;
  frame = requestAnimationFrame((nowMs) => {
    frame = 0;
    draw(nowMs);
    wake();
  });
}

/** Draw immediately all surfaces that are due; called within a frame, so that canvases change together with the other elements. */
export function drawDue() {
  cancelAnimationFrame(frame);
  frame = 0;
  if (!document.hidden) draw(performance.now());
  wake();
}

function recolour() {
  colours = null;
  for (const surface of all) surface.changed();
}

/** @returns {Colours} */
function theme() {
  if (!colours) {
    const style = getComputedStyle(document.documentElement);
    colours = Object.fromEntries(NAMES.map((name) => [name, style.getPropertyValue(`--draw-${name}`).trim() || "gray"]));
    colours.font = style.getPropertyValue("--draw-font").trim() || "sans-serif";
  }
  return colours;
}

const still = matchMedia("(prefers-reduced-motion: reduce)");

/** @returns {boolean} whether the user prefers reduced motion */
export function calm() {
  return still.matches;
}

document.addEventListener("visibilitychange", wake);
still.addEventListener("change", recolour);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", recolour);
new MutationObserver(recolour).observe(document.documentElement, { attributeFilter: ["class", "data-theme", "style"] });

/**
 * An element that is drawn after changes: `step` draws it, and returns whether it is still moving.
 */
export class Moving {
  /**
   * @param {HTMLElement} element
   * @param {(nowMs: number) => boolean | void} step
   * @param {number} [intervalMs] between two frames
   */
  constructor(element, step, intervalMs = FASTEST_MS) {
    this.element = element;
    this.step = step;
    this.intervalMs = intervalMs;
    this.width = 0;
    this.height = 0;
    this.seen = false;
    this.lastMs = -Infinity;
    this.sizes = new ResizeObserver(() => this.resized());
    this.sizes.observe(element);
    this.places = new IntersectionObserver((entries) => {
      this.seen = entries[entries.length - 1].isIntersecting;
      wake();
    });
    this.places.observe(element);
    all.add(this);
    this.changed();
  }

  /** Time from one frame to the next; off-screen drawings are kept up to date for prints and screenshots of the page. */
  get dueMs() {
    return this.seen ? this.intervalMs : UNSEEN_MS;
  }

  close() {
    this.sizes.disconnect();
    this.places.disconnect();
    all.delete(this);
    waiting.delete(this);
  }

  /** Draw it with the next frame. */
  changed() {
    waiting.add(this);
    wake();
  }

  resized() {
    this.width = this.element.clientWidth;
    this.height = this.element.clientHeight;
    this.lastMs = -Infinity;
    this.changed();
  }

  /** @param {number} nowMs */
  paint(nowMs) {
    if (this.width && this.step(nowMs)) this.changed();
  }
}

/** A canvas that is drawn after changes. */
export class Surface extends Moving {
  /**
   * @param {HTMLCanvasElement} canvas its size is set by the style sheet
   * @param {Draw} draw
   * @param {number} [intervalMs] between two frames
   */
  constructor(canvas, draw, intervalMs = FASTEST_MS) {
    super(canvas, () => {}, intervalMs);
    this.canvas = canvas;
    this.draw = draw;
    this.context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  }

  /** @param {number} nowMs */
  paint(nowMs) {
    const { canvas, context, width, height } = this;
    if (!width || !height) return;
    const ratio = window.devicePixelRatio || 1;
    const [across, down] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (canvas.width !== across || canvas.height !== down) {
      canvas.width = across;
      canvas.height = down;
    }
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    if (this.draw(context, width, height, theme(), nowMs)) this.changed();
  }
}

/**
 * Return the present colours.
 * @returns {Colours}
 */
export function currentColours() {
  return theme();
}
