/**
 * Pointer and key input on the picture of the scope: drag, pinch, wheel, cursors.
 */

const NEAR_MOUSE = 7; // px from a cursor within which it is grabbed
const NEAR_TOUCH = 22;
const WHEEL = 0.0016; // zoom per unit of the wheel
const TAP_PX = 5;
const TAP_MS = 350;

/**
 * @typedef {object} Hands
 * @property {(px: number, pinched: boolean) => void} pan by a number of px
 * @property {(factor: number, at: number) => void} zoom about a position, in px from the left
 * @property {(at: number, within: number) => number | null} grip the cursor at a position
 * @property {(cursor: number, at: number) => void} move move a cursor to a position
 * @property {(at: number) => void} tap
 */

/**
 * @param {HTMLElement} element
 * @param {Hands} hands
 */
export function onPointers(element, hands) {
  /** @type {Map<number, {x: number, y: number}>} */
  const down = new Map();
  /** @type {number | null} */
  let cursor = null;
  let [movedPx, sinceMs] = [0, 0];
  const place = (/** @type {MouseEvent} */ event) => event.clientX - element.getBoundingClientRect().left;

  element.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    element.setPointerCapture(event.pointerId);
    down.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (down.size === 1) {
      cursor = hands.grip(place(event), event.pointerType === "mouse" ? NEAR_MOUSE : NEAR_TOUCH);
      [movedPx, sinceMs] = [0, performance.now()];
    } else {
      cursor = null;
      movedPx = Infinity; // two fingers are not a tap
    }
  });
  element.addEventListener("pointermove", (event) => {
    const before = down.get(event.pointerId);
    if (!before) {
      element.style.cursor = hands.grip(place(event), NEAR_MOUSE) === null ? "" : "ew-resize";
      return;
    }
    const by = event.clientX - before.x;
    movedPx += Math.abs(by) + Math.abs(event.clientY - before.y);
    if (cursor !== null) {
      hands.move(cursor, place(event));
    } else if (down.size === 1) {
      if (movedPx > TAP_PX) hands.pan(by, false);
    } else {
      const other = [...down].find(([id]) => id !== event.pointerId)?.[1];
      if (other) pinch(before, other, event);
    }
    down.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });

  /**
   * @param {{x: number, y: number}} before
   * @param {{x: number, y: number}} other
   * @param {PointerEvent} event
   */
  function pinch(before, other, event) {
    const apart = (/** @type {{x: number, y: number}} */ one) => Math.max(Math.hypot(one.x - other.x, one.y - other.y), 20);
    const left = element.getBoundingClientRect().left;
    hands.pan((event.clientX - before.x) / 2, true);
    hands.zoom(apart(before) / apart({ x: event.clientX, y: event.clientY }), (event.clientX + other.x) / 2 - left);
  }

  const up = (/** @type {PointerEvent} */ event) => {
    if (!down.delete(event.pointerId)) return;
    const tapped = event.type === "pointerup" && movedPx <= TAP_PX && performance.now() - sinceMs < TAP_MS;
    if (!down.size && tapped && cursor === null) hands.tap(place(event));
    if (!down.size) cursor = null;
  };
  for (const name of /** @type {const} */ (["pointerup", "pointercancel", "lostpointercapture"])) {
    element.addEventListener(name, up);
  }
  element.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      const unit = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
      const sideways = event.shiftKey ? event.deltaX || event.deltaY : event.deltaX;
      if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) hands.pan(-sideways * unit, false);
      else hands.zoom(Math.exp(event.deltaY * unit * WHEEL), place(event));
    },
    { passive: false },
  );
}
