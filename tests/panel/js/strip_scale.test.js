import assert from "node:assert/strict";
import test from "node:test";

import { isSet, shownSpan, stripRange } from "../../../src/slewline/panel/page/strip_scale.js";

const S = 1e12;

test("a run that has just begun fills the strip, a long one shows its last seconds", () => {
  assert.equal(shownSpan(0, 10 * S), 1 * S);
  assert.equal(shownSpan(4 * S, 10 * S), 4 * S);
  assert.equal(shownSpan(60 * S, 10 * S), 10 * S);
  assert.equal(shownSpan(0.05 * S, 0.1 * S), 0.05 * S); // a tenth of real time
});

test("a velocity is as high as the strip, whatever it is", () => {
  const [low, high] = stripRange(0, 6000, true);
  assert.equal(low, 0);
  assert.ok(high > 6000 && high < 6600);
  const [back, forth] = stripRange(-6000, 6000, true);
  assert.ok(back < -6000 && back > -7000 && forth > 6000 && forth < 7000);
  assert.deepEqual(stripRange(0, 0, true), [0, 1]);
  assert.deepEqual(stripRange(7, 7, false), [6, 8]);
  assert.ok(stripRange(100, 110, true)[0] === 0 && stripRange(100, 110, false)[0] > 99);
});

test("a position that is set is not a move", () => {
  assert.ok(isSet(-42330, 0.033 * S, 0));
  assert.ok(!isSet(3000, 0.033 * S, 0)); // at 90,000 steps/s
  assert.ok(!isSet(33000, 0.033 * S, 1e6)); // of a motor that has been as fast
  assert.ok(!isSet(5, 0, 0));
});
