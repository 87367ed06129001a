/**
 * Motion between views: the present value of a quantity, extrapolated from the views.  No drawing here.
 */

const EASE_MS = 60; // time constant for correcting a difference
const STALE_MS = 250; // time without a view after which motion stops
const SOON_MS = 20; // interval within which an equal value counts as the same view
const CLOSE = 0.02; // steps: within this distance, the value has arrived

export class Follower {
  constructor() {
    this.value = NaN; // value of the last view
    this.shown = NaN;
    this.perMs = 0; // speed in wall-clock time
    this.difference = 0; // between the last two views
    this.viewMs = 0;
    this.shownMs = 0;
  }

  /**
   * Take the value of a view.
   * @param {number} value
   * @param {number} nowMs
   */
  take(value, nowMs) {
    const sinceMs = nowMs - this.viewMs;
    if (Number.isNaN(this.value) || sinceMs > 4 * STALE_MS) this.jump(value, nowMs);
    if (sinceMs < 1 || (value === this.value && sinceMs < SOON_MS)) return; // the same view again
    const difference = value - this.value;
    // a single step is not a speed: extrapolate only if the motion continues in the same direction
    const steady = difference * this.difference > 0;
    const speed = steady ? difference / sinceMs : 0;
    this.perMs = steady && this.perMs ? 0.5 * (this.perMs + speed) : speed;
    this.difference = difference;
    this.value = value;
    this.viewMs = nowMs;
  }

  /**
   * Jump to a value immediately, as after going back in time.
   * @param {number} value
   * @param {number} nowMs
   */
  jump(value, nowMs) {
    this.value = this.shown = value;
    this.perMs = this.difference = 0;
    this.viewMs = this.shownMs = nowMs;
  }

  /**
   * Return the value to be drawn.
   * @param {number} nowMs
   * @returns {number}
   */
  at(nowMs) {
    const passedMs = Math.min(Math.max(nowMs - this.shownMs, 0), STALE_MS);
    if (nowMs - this.viewMs > STALE_MS) this.perMs = 0;
    const ahead = this.perMs * Math.max(nowMs - this.viewMs, 0);
    const target = this.value + ahead;
    this.shown += this.perMs * passedMs;
    this.shown += (target - this.shown) * (1 - Math.exp(-passedMs / EASE_MS));
    this.shownMs = nowMs;
    if (!this.perMs && Math.abs(this.value - this.shown) < CLOSE) this.shown = this.value;
    return this.shown;
  }

  /** @returns {boolean} whether it moves, or has not yet reached the value of the last view */
  get moves() {
    return this.perMs !== 0 || this.shown !== this.value;
  }
}

/**
 * A fixed number of the last values of a quantity over time.
 */
export class Ring {
  /** @param {number} size */
  constructor(size) {
    this.times = new Float64Array(size);
    this.values = new Float64Array(size);
    this.first = 0;
    this.count = 0;
  }

  /**
   * Add a value; later values are dropped, because time has gone back.
   * @param {number} ps
   * @param {number} value
   */
  add(ps, value) {
    while (this.count && this.time(this.count - 1) >= ps) this.count--;
    const size = this.times.length;
    if (this.count === size) this.first = (this.first + 1) % size;
    else this.count++;
    const at = (this.first + this.count - 1) % size;
    this.times[at] = ps;
    this.values[at] = value;
  }

  /**
   * @param {number} n 0 is the oldest
   * @returns {number}
   */
  time(n) {
    return this.times[(this.first + n) % this.times.length];
  }

  /**
   * @param {number} n
   * @returns {number}
   */
  value(n) {
    return this.values[(this.first + n) % this.values.length];
  }

  /**
   * Return the index of the last value at or before an instant, at least 0.
   * @param {number} ps
   * @returns {number}
   */
  before(ps) {
    let [low, high] = [0, this.count];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time(middle) <= ps) low = middle + 1;
      else high = middle;
    }
    return Math.max(low - 1, 0);
  }
}
