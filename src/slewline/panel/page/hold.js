/**
 * Press and hold: a button that acts while it is pressed, by pointer or keyboard.
 *
 * A press of the keyboard lasts from the first keydown to the keyup; it also ends when the page loses the focus, so that
 * no button remains pressed by mistake.
 */

/**
 * Call `down` when a press begins and `up` when it ends.
 * @param {HTMLElement} element
 * @param {() => void} down
 * @param {(heldMs: number) => void} up with the duration of the press
 */
export function onHold(element, down, up) {
  let since = 0;
  let pressed = false;
  const begin = () => {
    if (pressed) return;
    pressed = true;
    since = performance.now();
    down();
  };
  const end = () => {
    if (!pressed) return;
    pressed = false;
    up(performance.now() - since);
  };
  element.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    // this element receives the release, wherever the pointer is
    element.setPointerCapture(event.pointerId);
    begin();
  });
  for (const name of ["pointerup", "pointercancel", "lostpointercapture", "blur"]) element.addEventListener(name, end);
  element.addEventListener("contextmenu", (event) => {
    if (pressed) event.preventDefault(); // a long touch counts as a press
  });
  element.addEventListener("keydown", (event) => {
    if (event.key !== " " && event.key !== "Enter") return;
    event.preventDefault();
    if (!event.repeat) begin();
  });
  element.addEventListener("keyup", (event) => {
    if (event.key !== " " && event.key !== "Enter") return;
    event.preventDefault(); // otherwise a click would follow
    end();
  });
  element.addEventListener("click", (event) => {
    if (event.detail !== 0) return;
    begin(); // a click without a pointer, for example by a screen reader, is a short press
    end();
  });
}
