/**
 * Motion between views: where something is now, from what the views have said about it.  No drawing here.
 */

const EASE_MS = 60; // in which most of a difference is made up
const PATIENCE_MS = 250; // without a view for so long, it stands
const SOON_MS = 20; // within which nothing new is said
const CLOSE = 0.02; // steps: what is nearer than that has arrived

export class Follower {
  constructor() {
    this.value = NaN; // as the last view says
    this.shown = NaN;
    this.perMs = 0; // speed on the clock of the wall
    this.difference = 0; // between the last two views
    this.viewMs = 0;
    this.shownMs = 0;
  }

  /**
   * Take what a view says.
   * @param {number} value
   * @param {number} nowMs
   */
  take(value, nowMs) {
    const sinceMs = nowMs - this.viewMs;
    if (Number.isNaN(this.value) || sinceMs > 4 * PATIENCE_MS) this.jump(value, nowMs);
    if (sinceMs < 1 || (value === this.value && sinceMs < SOON_MS)) return; // the same view again
    const difference = value - this.value;
    // a single step is no speed: only what goes on in the same direction is carried on
    const steady = difference * this.difference > 0;
    const speed = steady ? difference / sinceMs : 0;
    this.perMs = steady && this.perMs ? 0.5 * (this.perMs + speed) : speed;
    this.difference = difference;
    this.value = value;
    this.viewMs = nowMs;
  }

  /**
   * Be somewhere at once, as after a journey in time.
   * @param {number} value
   * @param {number} nowMs
   */
  jump(value, nowMs) {
    this.value = this.shown = value;
    this.perMs = this.difference = 0;
    this.viewMs = this.shownMs = nowMs;
  }

  /**
   * Return where it is to be drawn.
   * @param {number} nowMs
   * @returns {number}
   */
  at(nowMs) {
    const passedMs = Math.min(Math.max(nowMs - this.shownMs, 0), PATIENCE_MS);
    if (nowMs - this.viewMs > PATIENCE_MS) this.perMs = 0;
    const ahead = this.perMs * Math.max(nowMs - this.viewMs, 0);
    const target = this.value + ahead;
    this.shown += this.perMs * passedMs;
    this.shown += (target - this.shown) * (1 - Math.exp(-passedMs / EASE_MS));
    this.shownMs = nowMs;
    if (!this.perMs && Math.abs(this.value - this.shown) < CLOSE) this.shown = this.value;
    return this.shown;
  }

  /** @returns {boolean} does it move, or is it still to move to where the last view has it? */
  get moves() {
    return this.perMs !== 0 || this.shown !== this.value;
  }
}

/**
 * The last values of something over time, a fixed number of them.
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
   * Add a value; what is later than it is dropped, since time has gone back.
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
   * @param {number} n 0 is the oldest one
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
   * Return the number of the last value at or before an instant, 0 at least.
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
