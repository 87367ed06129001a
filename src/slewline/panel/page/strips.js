/**
 * Strips of velocity and position of an axis, of the last seconds.
 */

import { h } from "./dom.js";
import { Ring } from "./motion.js";
import { SPAN_S, isSet, shownSpan, stripRange } from "./strip_scale.js";
import { Surface } from "./surface.js";
import { SECOND, digitsOf, timeText } from "./units.js";

/** @typedef {import("./surface.js").Colours} Colours */

const KEPT = 640; // values of each quantity: twice those of ten seconds of views
const PICTURE_MS = 100;
const VELOCITY_SHARE = 0.6; // of the height
const GAP = 0.05; // of the span
const LEFT = 6;

export class Strips {
  /** @param {string} name accessible name */
  constructor(name) {
    this.velocity = new Ring(KEPT);
    this.position = new Ring(KEPT);
    this.nowPs = 0;
    this.setPs = -Infinity; // when the position was last set to another value, without steps
    this.fastest = 0; // steps/s, so far
    this.spanPs = SPAN_S * SECOND;
    this.canvas = h("canvas", { class: "strips", role: "img", "aria-label": `${name}: velocity and position over time` });
    this.surface = new Surface(this.canvas, (...all) => this.draw(...all), PICTURE_MS);
  }

  close() {
    this.surface.close();
  }

  /**
   * Take the values of a view.
   * @param {number} ps
   * @param {number} position
   * @param {number} velocity
   * @param {number} rate virtual seconds per second
   */
  take(ps, position, velocity, rate) {
    const spanPs = SPAN_S * rate * SECOND;
    if (ps === this.nowPs && this.velocity.count && spanPs === this.spanPs) return;
    this.spanPs = spanPs;
    this.nowPs = ps;
    const last = this.position.count - 1;
    if (last >= 0 && isSet(position - this.position.value(last), ps - this.position.time(last), this.fastest)) this.setPs = ps;
    this.fastest = Math.max(this.fastest, Math.abs(velocity));
    this.velocity.add(ps, velocity);
    this.position.add(ps, position);
    this.surface.changed();
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {number} width
   * @param {number} height
   * @param {Colours} colours
   * @param {number} _nowMs
   */
  draw(context, width, height, colours, _nowMs) {
    const upper = Math.floor((height - 16) * VELOCITY_SHARE);
    const lower = height - 16 - upper;
    context.font = `11px ${colours.font}`;
    const spanPs = shownSpan(this.velocity.count ? this.nowPs - this.velocity.time(0) : 0, this.spanPs);
    const from = this.nowPs - spanPs;
    const x = (/** @type {number} */ ps) => LEFT + ((ps - from) / spanPs) * (width - 2 * LEFT);
    grid(context, width, height - 15, colours);
    const gapPs = this.spanPs * GAP;
    strip(context, this.velocity, x, from, 0, upper - 4, true, ["velocity", "steps/s"], colours.velocity, colours, width, gapPs);
    strip(context, this.position, x, Math.max(from, this.setPs), upper + 4, lower - 4, false, ["position", "steps"], colours.position, colours, width, gapPs);
    context.fillStyle = colours.muted;
    context.textBaseline = "bottom";
    context.textAlign = "left";
    context.fillText(`${timeText(-spanPs, 3)}`, LEFT, height);
    context.textAlign = "right";
    context.fillText("now", width - LEFT, height);
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} width
 * @param {number} height
 * @param {Colours} colours
 */
function grid(context, width, height, colours) {
  context.beginPath();
  for (let n = 0; n <= SPAN_S; n++) {
    const x = Math.round(LEFT + (n / SPAN_S) * (width - 2 * LEFT)) + 0.5;
    context.moveTo(x, 0);
    context.lineTo(x, height);
  }
  context.strokeStyle = colours.faint;
  context.stroke();
}

/**
 * Return whether the values between two consecutive ones are unknown, as after a long jump in time.
 * @param {Ring} ring
 * @param {number} n
 * @param {number} gapPs
 * @returns {boolean}
 */
function isGap(ring, n, gapPs) {
  return ring.time(n) - ring.time(n - 1) > gapPs && ring.value(n) !== ring.value(n - 1);
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Ring} ring
 * @param {(ps: number) => number} x
 * @param {number} from
 * @param {number} top
 * @param {number} height
 * @param {boolean} zero whether its range includes 0
 * @param {string[]} words
 * @param {string} colour
 * @param {Colours} colours
 * @param {number} width
 * @param {number} gapPs between two views, above which no line connects them
 */
function strip(context, ring, x, from, top, height, zero, words, colour, colours, width, gapPs) {
  const first = ring.count ? ring.before(from) : 0;
  let [low, high] = zero ? [0, 0] : [Infinity, -Infinity];
  for (let n = first; n < ring.count; n++) {
    low = Math.min(low, ring.value(n));
    high = Math.max(high, ring.value(n));
  }
  if (low > high) [low, high] = [0, 0];
  const label = `${digitsOf(low, 4)} \u2026 ${digitsOf(high, 4)} ${words[1]}`;
  [low, high] = stripRange(low, high, zero);
  const inside = height - 15;
  const y = (/** @type {number} */ value) => top + 14 + inside - ((value - low) / (high - low)) * inside;
  context.strokeStyle = colours.line;
  context.beginPath();
  const base = Math.round(y(zero ? 0 : low)) + 0.5;
  context.moveTo(LEFT, base);
  context.lineTo(width - LEFT, base);
  context.stroke();
  context.save();
  context.beginPath();
  context.rect(LEFT, top, width - 2 * LEFT, height + 2);
  context.clip();
  context.beginPath();
  for (let n = first; n < ring.count; n++) {
    const [across, down] = [x(ring.time(n)), y(ring.value(n))];
    if (n > first && isGap(ring, n, gapPs)) context.moveTo(across, down);
    context.lineTo(across, down);
  }
  context.strokeStyle = colour;
  context.lineWidth = 1.5;
  context.lineJoin = "round";
  context.stroke();
  context.restore();
  context.lineWidth = 1;
  context.textBaseline = "top";
  context.textAlign = "left";
  context.fillStyle = colour;
  context.fillText(words[0], LEFT + 2, top);
  context.textAlign = "right";
  context.fillStyle = colours.muted;
  context.fillText(label, width - LEFT - 2, top);
}
