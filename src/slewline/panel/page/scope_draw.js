/**
 * The picture of the scope: a ruler of time, and a lane for each signal.
 */

import { extent } from "./window_data.js";
import { digitsOf, instantText, roundRange, timeTicks } from "./units.js";

/** @typedef {import("./surface.js").Colours} Colours */
/** @typedef {import("./window_data.js").Trace} Trace */
/** @typedef {import("./window_data.js").PinTrace} PinTrace */
/** @typedef {import("./window_data.js").QuantityTrace} QuantityTrace */

/**
 * @typedef {object} Picture
 * @property {number} start
 * @property {number} stop
 * @property {string[]} signals
 * @property {Map<string, Trace>} traces
 * @property {Set<string>} quantities the signals with values
 * @property {(number | null)[]} cursors A and B
 * @property {number} active the cursor moved by keys
 * @property {number | null} found instant of the trigger
 * @property {number} now
 */

const RULER = 34;
const BASE = 14; // below the ruler, for the base of its times, if there is no room at its side
const PIN_LANE = 34;
const CURVE_LANE = 92;
const GAP = 6;
const HEAD = 15; // of a lane, if there is no room for names at its side
export const CURSOR_NAMES = ["A", "B"];

/**
 * Return the width of the names, 0 if they are above the lanes.
 * @param {number} width
 * @returns {number}
 */
export function gutter(width) {
  return width < 560 ? 0 : 150;
}

/**
 * Return the top of the first lane.
 * @param {number} width
 * @returns {number}
 */
function lanesTop(width) {
  return gutter(width) ? RULER : RULER + BASE;
}

/**
 * Return the height of a lane.
 * @param {boolean} curve
 * @param {number} width
 * @returns {number}
 */
function laneHeight(curve, width) {
  return (curve ? CURVE_LANE : PIN_LANE) + (gutter(width) ? 0 : HEAD);
}

/**
 * Return the height of the whole picture.
 * @param {Pick<Picture, "signals" | "quantities">} picture
 * @param {number} width
 * @returns {number}
 */
export function pictureHeight(picture, width) {
  const lanes = picture.signals.map((name) => laneHeight(picture.quantities.has(name), width) + GAP);
  return lanesTop(width) + lanes.reduce((sum, one) => sum + one, 0) + GAP;
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} width
 * @param {number} height
 * @param {Colours} colours
 * @param {Picture} picture
 */
export function drawScope(context, width, height, colours, picture) {
  const left = gutter(width);
  const { start, stop } = picture;
  const x = (/** @type {number} */ ps) => left + ((ps - start) / (stop - start)) * (width - left);
  context.font = `11px ${colours.font}`;
  ruler(context, left, width, height, x, picture, colours);
  let top = lanesTop(width);
  for (const name of picture.signals) {
    const curve = picture.quantities.has(name);
    const tall = laneHeight(curve, width);
    const trace = picture.traces.get(name);
    const inner = top + (left ? 4 : HEAD + 2);
    const below = top + tall - 4;
    context.save();
    context.beginPath();
    context.rect(left, top, width - left, tall);
    context.clip();
    let range = "";
    if (trace?.kind === "pin") pinLane(context, trace, x, left, width, inner, below, colours);
    if (trace?.kind === "quantity") range = curveLane(context, trace, x, start, stop, left, width, inner, below, colours, name);
    context.restore();
    laneName(context, name, trace, range, left, width, top, tall, colours);
    top += tall + GAP;
    context.strokeStyle = colours.faint;
    line(context, 0, Math.round(top - GAP / 2) + 0.5, width, Math.round(top - GAP / 2) + 0.5);
  }
  if (picture.now < stop) {
    context.fillStyle = colours.body;
    context.globalAlpha = 0.5; // the future
    context.fillRect(Math.max(x(picture.now), left), RULER, width, height);
    context.globalAlpha = 1;
  }
  if (picture.found !== null) flag(context, x(picture.found), left, width, height, "T", colours.trigger, false, colours);
  picture.cursors.forEach((ps, n) => {
    const colour = colours[n ? "cursor-b" : "cursor-a"];
    if (ps !== null) flag(context, x(ps), left, width, height, CURSOR_NAMES[n], colour, picture.active === n, colours);
  });
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} x1
 * @param {number} y1
 * @param {number} x2
 * @param {number} y2
 */
function line(context, x1, y1, x2, y2) {
  context.beginPath();
  context.moveTo(x1, y1);
  context.lineTo(x2, y2);
  context.stroke();
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} left
 * @param {number} width
 * @param {number} height
 * @param {(ps: number) => number} x
 * @param {Picture} picture
 * @param {Colours} colours
 */
function ruler(context, left, width, height, x, picture, colours) {
  const { start, stop } = picture;
  const { base, ticks, minor } = timeTicks(start, stop, Math.max(Math.floor((width - left) / 96), 2));
  context.strokeStyle = colours.line;
  line(context, left, RULER - 5.5, width, RULER - 5.5);
  context.beginPath();
  for (let n = Math.ceil(start / minor); n * minor <= stop; n++) {
    const at = Math.round(x(n * minor)) + 0.5;
    context.moveTo(at, RULER - 9);
    context.lineTo(at, RULER - 5);
  }
  context.stroke();
  context.textBaseline = "alphabetic";
  context.textAlign = "center";
  for (const { ps, text } of ticks) {
    const at = Math.round(x(ps)) + 0.5;
    context.strokeStyle = colours.faint;
    line(context, at, RULER - 5, at, height);
    context.strokeStyle = colours.muted;
    line(context, at, RULER - 13, at, RULER - 5);
    context.fillStyle = colours.muted;
    const half = context.measureText(text).width / 2;
    if (at - half >= left && at + half <= width) context.fillText(text, at, RULER - 17);
  }
  if (!base) return;
  context.textAlign = "left";
  context.fillStyle = colours.ink;
  const text = instantText(base, minor);
  if (left) context.fillText(text, 8, RULER - 17);
  else context.fillText(text, 2, RULER + 8);
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {string} name
 * @param {Trace | undefined} trace
 * @param {string} range
 * @param {number} left
 * @param {number} width
 * @param {number} top
 * @param {number} tall
 * @param {Colours} colours
 */
function laneName(context, name, trace, range, left, width, top, tall, colours) {
  const middle = left ? top + tall / 2 - (range ? 7 : 0) : top + HEAD / 2 + 1;
  context.textBaseline = "middle";
  context.textAlign = "left";
  context.fillStyle = colours.ink;
  context.font = `12px ${colours.font}`;
  context.fillText(name, left ? 8 : 2, middle, left ? left - 16 : width / 2);
  context.font = `11px ${colours.font}`;
  context.fillStyle = colours.muted;
  if (!trace) {
    context.fillText("\u2026", left ? left - 16 : width - 12, middle);
  } else if (range) {
    context.textAlign = left ? "left" : "right";
    context.fillText(range, left ? 8 : width - 2, left ? middle + 15 : middle, left ? left - 16 : width / 2);
  }
}

/**
 * Draw the levels of a pin: lines at both levels and between, a band if there are more edges than columns.
 * @param {CanvasRenderingContext2D} context
 * @param {PinTrace} trace
 * @param {(ps: number) => number} x
 * @param {number} left
 * @param {number} width
 * @param {number} top
 * @param {number} bottom
 * @param {Colours} colours
 */
function pinLane(context, trace, x, left, width, top, bottom, colours) {
  const [high, low, open] = [Math.round(top) + 1, Math.round(bottom) - 1, Math.round((top + bottom) / 2)];
  const y = (/** @type {string} */ level) => (level === "1" ? high : level === "0" ? low : open);
  const count = trace.levels.length;
  const step = (trace.stop - trace.start) / count;
  const time = (/** @type {number} */ n) =>
    n >= count ? trace.stop : trace.decimated ? trace.start + n * step : Math.max(trace.times[n], trace.start);
  context.fillStyle = colours.high;
  const runs = [];
  for (let n = 0; n < count; ) {
    let end = n + 1;
    while (end < count && trace.levels[end] === trace.levels[n]) end++;
    runs.push({ level: trace.levels[n], from: x(time(n)), to: x(time(end)) });
    n = end;
  }
  for (const { level, from, to } of runs) {
    if (to < left || from > width) continue;
    // a high level is tinted, so it differs from a low one by more than the position of a line
    context.globalAlpha = level === "x" ? 0.55 : 0.13;
    if (level === "x" || level === "1") context.fillRect(from, high, Math.max(to - from, 0.5), low - high);
  }
  context.globalAlpha = 1;
  context.lineWidth = runs.length > (width - left) / 8 ? 1 : 1.5;
  context.strokeStyle = colours.high;
  context.beginPath();
  let before = "";
  for (const { level, from, to } of runs) {
    if (to >= left - 2 && from <= width + 2) {
      if (level === "x") {
        context.moveTo(to, y("1"));
      } else if (level !== "-") {
        if (before === "0" || before === "1") context.lineTo(from, y(level));
        else context.moveTo(from, y(level));
        context.lineTo(to, y(level));
      }
    }
    before = level;
  }
  context.stroke();
  context.setLineDash([3, 3]);
  context.strokeStyle = colours.open;
  for (const { level, from, to } of runs) if (level === "-") line(context, from, open, to, open);
  context.setLineDash([]);
  context.lineWidth = 1;
  if (trace.since > trace.start) unknown(context, left, Math.min(x(trace.since), width), high, low, colours);
}

/**
 * Hatch the time in which the pin was not recorded.
 * @param {CanvasRenderingContext2D} context
 * @param {number} from
 * @param {number} to
 * @param {number} top
 * @param {number} bottom
 * @param {Colours} colours
 */
function unknown(context, from, to, top, bottom, colours) {
  if (to <= from) return;
  context.save();
  context.beginPath();
  context.rect(from, top - 2, to - from, bottom - top + 4);
  context.clip();
  context.fillStyle = colours.ground;
  context.fillRect(from, top - 2, to - from, bottom - top + 4);
  context.strokeStyle = colours.line;
  context.beginPath();
  for (let at = from - (bottom - top); at < to; at += 8) {
    context.moveTo(at, bottom);
    context.lineTo(at + bottom - top, top);
  }
  context.stroke();
  context.textAlign = "center";
  context.textBaseline = "middle";
  const text = "not recorded";
  const size = context.measureText(text).width + 12;
  if (to - from > size + 12) {
    context.fillStyle = colours.ground;
    context.fillRect((from + to - size) / 2, top - 2, size, bottom - top + 4);
    context.fillStyle = colours.muted;
    context.fillText(text, (from + to) / 2, (top + bottom) / 2);
  }
  context.restore();
}

/**
 * Draw the values of a quantity, and return the range of the lane as text.
 * @param {CanvasRenderingContext2D} context
 * @param {QuantityTrace} trace
 * @param {(ps: number) => number} x
 * @param {number} start
 * @param {number} stop
 * @param {number} left
 * @param {number} width
 * @param {number} top
 * @param {number} bottom
 * @param {Colours} colours
 * @param {string} name
 * @returns {string}
 */
function curveLane(context, trace, x, start, stop, left, width, top, bottom, colours, name) {
  const found = extent(trace, start, stop);
  if (!found) return "";
  const speed = /velocity/.test(name);
  const rest = speed && !found[0] && !found[1];
  const [low, high] = rest ? [0, 1] : speed ? roundRange(Math.min(found[0], 0), Math.max(found[1], 0)) : roundRange(...found);
  const y = (/** @type {number} */ value) => bottom - 1 - ((value - low) / (high - low)) * (bottom - top - 2);
  context.strokeStyle = colours.faint;
  for (const value of [low, (low + high) / 2, high]) {
    line(context, left, Math.round(y(value)) + 0.5, width, Math.round(y(value)) + 0.5);
  }
  if (low < 0 && high > 0) {
    context.strokeStyle = colours.line;
    line(context, left, Math.round(y(0)) + 0.5, width, Math.round(y(0)) + 0.5);
  }
  context.strokeStyle = speed ? colours.velocity : colours.position;
  context.lineWidth = 1.5;
  context.lineJoin = "round";
  context.beginPath();
  let pen = false;
  let last = 0;
  trace.times.forEach((ps, n) => {
    const value = trace.values[n];
    if (value === null) {
      if (pen && trace.held) context.lineTo(x(ps), last);
      pen = false;
      return;
    }
    if (pen && trace.held) context.lineTo(x(ps), last);
    last = y(value);
    if (pen) context.lineTo(x(ps), last);
    else context.moveTo(x(ps), last);
    pen = true;
  });
  if (pen && trace.held) context.lineTo(x(trace.stop), last);
  context.stroke();
  context.lineWidth = 1;
  return `${digitsOf(low, 6)} \u2026 ${digitsOf(high, 6)} ${trace.unit}`;
}

/**
 * Draw the line of a cursor through all lanes, with its letter on the ruler.
 * @param {CanvasRenderingContext2D} context
 * @param {number} at
 * @param {number} left
 * @param {number} width
 * @param {number} height
 * @param {string} letter
 * @param {string} colour
 * @param {boolean} active
 * @param {Colours} colours
 */
function flag(context, at, left, width, height, letter, colour, active, colours) {
  if (at < left - 1 || at > width + 1) return;
  const x = Math.min(Math.max(Math.round(at) + 0.5, left + 0.5), width - 0.5);
  context.strokeStyle = colour;
  if (letter === "T") context.setLineDash([2, 3]);
  line(context, x, 14, x, height);
  context.setLineDash([]);
  const box = Math.min(Math.max(x, left + 8), width - 8);
  context.beginPath();
  context.roundRect(box - 8, 0, 16, 15, 3);
  context.fillStyle = colour;
  context.fill();
  if (active) {
    context.strokeStyle = colours.ink;
    context.stroke();
  }
  context.font = `bold 11px ${colours.font}`;
  context.fillStyle = colours.ground;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(letter, box, 8);
  context.font = `11px ${colours.font}`;
}
