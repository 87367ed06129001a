import assert from "node:assert/strict";
import { test } from "node:test";

import { Follower, Ring } from "../../../src/slewline/panel/page/motion.js";

test("steady motion is drawn between the views, and arrives", () => {
  const follower = new Follower();
  let nowMs = 0;
  for (let n = 0; n < 30; n++, nowMs += 33) follower.take(10 * n, nowMs);
  const last = follower.viewMs;
  const [soon, later] = [follower.at(last + 11), follower.at(last + 22)];
  assert.ok(later > soon && later < 300 && soon > 280, `${soon} ${later}`);
  for (let n = 0; n < 60; n++) follower.at(last + 22 + 33 * n);
  assert.equal(follower.at(last + 3000), 290);
  assert.equal(follower.moves, false);
});

test("a single step is not a speed", () => {
  const follower = new Follower();
  follower.take(0, 0);
  follower.take(0, 33);
  follower.take(1, 66);
  assert.equal(follower.perMs, 0);
  for (let ms = 66; ms < 1000; ms += 16) assert.ok(follower.at(ms) <= 1);
  assert.equal(follower.at(1000), 1);
});

test("a ring keeps the last values", () => {
  const ring = new Ring(4);
  for (let n = 0; n < 10; n++) ring.add(n * 10, n);
  assert.deepEqual([ring.count, ring.value(0), ring.value(3)], [4, 6, 9]);
  assert.equal(ring.before(75), 1);
  assert.equal(ring.before(0), 0);
});

test("time that goes back takes away what was later", () => {
  const ring = new Ring(8);
  for (let n = 0; n < 6; n++) ring.add(n * 10, n);
  ring.add(25, 99);
  assert.deepEqual([ring.count, ring.value(2), ring.value(3)], [4, 2, 99]);
});
