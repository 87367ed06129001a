/**
 * The scales of the strips: their time span and their range of values.  No drawing here.
 */

import { SECOND } from "./units.js";

const FAST = 100_000; // steps/s that any motor may reach between two views
const SLACK = 10; // steps
const ROOM = 0.06; // fraction of a range added above and below
export const SPAN_S = 10; // in wall-clock time

/**
 * Return the time span of a strip: at first the whole run as seen by the page, later its last part.
 * @param {number} seenPs
 * @param {number} spanPs maximum
 * @returns {number}
 */
export function shownSpan(seenPs, spanPs) {
  return Math.min(spanPs, Math.max(seenPs, spanPs / SPAN_S));
}

/**
 * Return whether a position was set to another value: no motor can step that far in that time.
 * @param {number} steps
 * @param {number} ps
 * @param {number} fastest steps/s seen so far
 * @returns {boolean}
 */
export function isSet(steps, ps, fastest) {
  return Math.abs(steps) > SLACK + (Math.max(FAST, 3 * fastest) * Math.abs(ps)) / SECOND;
}

/**
 * Return the ends of a strip: the values themselves and a small margin, so that a ramp uses the full height.
 * @param {number} low
 * @param {number} high
 * @param {boolean} zero whether the range includes 0
 * @returns {[number, number]}
 */
export function stripRange(low, high, zero) {
  if (zero) [low, high] = [Math.min(low, 0), Math.max(high, 0)];
  if (low === high) return [low - (zero ? 0 : 1), high + 1];
  const room = ROOM * (high - low);
  return [low - (low ? room : 0), high + (high ? room : 0)];
}
