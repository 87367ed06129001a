import assert from "node:assert/strict";
import { test } from "node:test";

import { digitsOf, instantText, niceStep, rateText, roundRange, ticks, timeText, timeTicks } from "../../../src/slewline/panel/page/units.js";

test("a time has the unit that suits it", () => {
  assert.equal(timeText(12.5e9), "12.5 ms");
  assert.equal(timeText(2e12), "2 s");
  assert.equal(timeText(-1500), "\u22121.5 ns");
  assert.equal(timeText(7), "7 ps");
  assert.equal(timeText(0), "0 s");
});

test("an instant has the decimals that the picture tells apart", () => {
  assert.equal(instantText(4.8832821e12, 1e6), "4.883\u202f282 s");
  assert.equal(instantText(1e12, 1e12), "1 s");
  assert.equal(instantText(123, 1), "0.000\u202f000\u202f000\u202f123 s");
});

test("a distance of time is a rate", () => {
  assert.equal(rateText(1e9), "1 kHz");
  assert.equal(rateText(-2e12), "500 mHz");
  assert.equal(rateText(0), "\u2013");
});

test("numbers have no zeros at the end, and a proper minus", () => {
  assert.equal(digitsOf(100, 3), "100");
  assert.equal(digitsOf(-0.25, 4), "\u22120.25");
  assert.equal(digitsOf(1234567, 4), "1234567");
});

test("steps of a scale are 1, 2 or 5 times a power of ten", () => {
  for (let span = 1e-3; span < 1e15; span *= 1.37) {
    const step = niceStep(span, 8);
    assert.ok(span / step <= 8 + 1e-6 && span / step > 3, `${span}: ${step}`);
    assert.match(String(Number(step.toPrecision(6))), /^0*\.?0*[125]0*(e|$)/);
  }
});

test("ticks lie within the scale", () => {
  assert.deepEqual(ticks(0, 10, 5), [0, 2, 4, 6, 8, 10]);
  assert.deepEqual(ticks(-3, 3, 3), [-2, 0, 2]);
});

test("a window far from 0 counts from a base", () => {
  const near = timeTicks(0, 1e12, 5);
  assert.equal(near.base, 0);
  assert.deepEqual(near.ticks.map((tick) => tick.text), ["0 s", "200 ms", "400 ms", "600 ms", "800 ms", "1 s"]);
  const far = timeTicks(3600e12, 3600e12 + 10e6, 5);
  assert.equal(far.base, 3600e12);
  assert.deepEqual(far.ticks.map((tick) => tick.text).slice(0, 2), ["0", "+2 \u00b5s"]);
});

test("a window of any size and place has few ticks", () => {
  for (let span = 1000; span < 1e17; span *= 7.3) {
    for (const start of [0, 1e6, 1e12, 7.2e15]) {
      const found = timeTicks(start, start + span, 8).ticks;
      assert.ok(found.length >= 1 && found.length <= 10, `${start} ${span}: ${found.length}`);
    }
  }
});

test("a range has round ends around its values", () => {
  assert.deepEqual(roundRange(3, 97), [0, 100]);
  assert.deepEqual(roundRange(5, 5), [4, 6]);
});
