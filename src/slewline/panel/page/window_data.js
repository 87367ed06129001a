/**
 * The data of a signal within a window of time: levels and values at instants.  No drawing here.
 */

/**
 * @typedef {object} PinTrace
 * @property {"pin"} kind
 * @property {number} start of the window, ps
 * @property {number} stop
 * @property {number} since start of the recording
 * @property {number[]} times of the edges, the first one being the start; empty if decimated
 * @property {string} levels after each edge: 0, 1 or - (floats); or, if decimated, a character per column, x if it has both
 * @property {boolean} decimated
 */

/**
 * @typedef {object} QuantityTrace
 * @property {"quantity"} kind
 * @property {number} start
 * @property {number} stop
 * @property {string} unit
 * @property {boolean} held true: a staircase; false: straight lines
 * @property {number[]} times
 * @property {(number | null)[]} values null: a break, unknown up to the next value
 */

/** @typedef {PinTrace | QuantityTrace} Trace */

/** @param {unknown} level */
function letter(level) {
  return level === 1 ? "1" : level === 0 ? "0" : "-";
}

/**
 * Return the data of one signal in a reply to `window`; a signal with an error has none.
 * @param {Record<string, any>} signal
 * @param {number} start
 * @param {number} stop
 * @returns {Trace}
 */
export function decoded(signal, start, stop) {
  if (signal.kind === "quantity") {
    const { unit = "", held = true, times_ps: times = [], values = [] } = signal;
    return { kind: "quantity", start, stop, unit, held, times, values };
  }
  const since = signal.error ? stop : Number(signal.since_ps ?? start);
  const decimated = typeof signal.columns === "string";
  const levels = decimated ? signal.columns : (signal.levels ?? []).map(letter).join("");
  return { kind: "pin", start, stop, since, times: signal.times_ps ?? [], levels, decimated };
}

/**
 * Return the index of the last time at or before an instant, or -1.
 * @param {ArrayLike<number>} times ascending
 * @param {number} ps
 * @returns {number}
 */
export function lastBefore(times, ps) {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= ps) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/**
 * Return the level of a pin at an instant: 0, 1, x (both, in the column there), - (floats), or "" if it is not known.
 * @param {PinTrace} trace
 * @param {number} ps
 * @returns {string}
 */
export function levelAt(trace, ps) {
  if (ps < trace.start || ps > trace.stop || ps < trace.since) return "";
  if (!trace.decimated) return trace.levels[Math.max(lastBefore(trace.times, ps), 0)] ?? "";
  const column = Math.floor(((ps - trace.start) / (trace.stop - trace.start)) * trace.levels.length);
  return trace.levels[Math.min(column, trace.levels.length - 1)] ?? "";
}

/**
 * Return the value of a quantity at an instant, or null if it has none.
 * @param {QuantityTrace} trace
 * @param {number} ps
 * @returns {number | null}
 */
export function valueAt(trace, ps) {
  if (ps < trace.start || ps > trace.stop) return null;
  const at = lastBefore(trace.times, ps);
  if (at < 0) return null;
  const [value, next] = [trace.values[at], trace.values[at + 1]];
  if (trace.held || value === null || next === null || next === undefined) return value;
  const [from, to] = [trace.times[at], trace.times[at + 1]];
  return to > from ? value + ((next - value) * (ps - from)) / (to - from) : value;
}

/**
 * Return the edge of a pin that is nearest to an instant, or null if none is within range.
 * @param {PinTrace} trace
 * @param {number} ps
 * @param {number} within
 * @returns {number | null}
 */
export function nearestEdge(trace, ps, within) {
  if (trace.decimated) return null;
  const at = lastBefore(trace.times, ps);
  let best = null;
  for (const n of [at, at + 1]) {
    const time = trace.times[n];
    if (n < 1 || time === undefined || Math.abs(time - ps) > within) continue; // the first time is only the start
    if (best === null || Math.abs(time - ps) < Math.abs(best - ps)) best = time;
  }
  return best;
}

/**
 * Return the least and the greatest value within a window, or null if there is none.
 * @param {QuantityTrace} trace
 * @param {number} start
 * @param {number} stop
 * @returns {[number, number] | null}
 */
export function extent(trace, start, stop) {
  let [low, high] = [Infinity, -Infinity];
  const last = lastBefore(trace.times, stop);
  for (let n = Math.max(lastBefore(trace.times, start), 0); n <= last; n++) {
    const value = trace.values[n];
    if (value === null) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  return low <= high ? [low, high] : null;
}

/**
 * Return a window of another length with an instant at the same place, as far as its start is not below 0.
 * @param {number} start
 * @param {number} stop
 * @param {number} factor below 1: shorter
 * @param {number} at
 * @param {number} least shortest length
 * @param {number} most longest length
 * @returns {[number, number]}
 */
export function zoomed(start, stop, factor, at, least, most) {
  const span = Math.min(Math.max((stop - start) * factor, least), most);
  const share = (at - start) / (stop - start);
  const from = Math.max(at - share * span, 0);
  return [from, from + span];
}
