/**
 * The scales of the strips: how long a time they show, and between which values.  No drawing here.
 */

import { SECOND } from "./units.js";

const FAST = 100_000; // steps/s that any motor may have reached between two views
const SLACK = 10; // steps
const ROOM = 0.06; // above and below, of a range
export const SPAN_S = 10; // on the clock of the wall

/**
 * Return how long a time is shown: all that the page has seen of a run, later the last of it.
 * @param {number} seenPs
 * @param {number} spanPs the most
 * @returns {number}
 */
export function shownSpan(seenPs, spanPs) {
  return Math.min(spanPs, Math.max(seenPs, spanPs / SPAN_S));
}

/**
 * Return whether a position was set to another value: no motor steps as far in that time.
 * @param {number} steps
 * @param {number} ps
 * @param {number} fastest steps/s that have been seen
 * @returns {boolean}
 */
export function isSet(steps, ps, fastest) {
  return Math.abs(steps) > SLACK + (Math.max(FAST, 3 * fastest) * Math.abs(ps)) / SECOND;
}

/**
 * Return the ends of a strip: the values themselves and a little room, so that a ramp is as high as it can be.
 * @param {number} low
 * @param {number} high
 * @param {boolean} zero the range has 0 in it
 * @returns {[number, number]}
 */
export function stripRange(low, high, zero) {
  if (zero) [low, high] = [Math.min(low, 0), Math.max(high, 0)];
  if (low === high) return [low - (zero ? 0 : 1), high + 1];
  const room = ROOM * (high - low);
  return [low - (low ? room : 0), high + (high ? room : 0)];
}
