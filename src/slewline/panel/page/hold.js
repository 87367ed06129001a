/**
 * Press and hold: a button that is worked for as long as it is pressed, by pointer or keyboard.
 *
 * A press of the keyboard counts from the first keydown to the keyup; the page losing the focus ends it as well, so that
 * nothing stays pressed which nobody presses.
 */

/**
 * Call `down` when a press begins and `up` when it ends.
 * @param {HTMLElement} element
 * @param {() => void} down
 * @param {(heldMs: number) => void} up with how long it was pressed
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
    // the release belongs to this element wherever the pointer is then
    element.setPointerCapture(event.pointerId);
    begin();
  });
  for (const name of ["pointerup", "pointercancel", "lostpointercapture", "blur"]) element.addEventListener(name, end);
  element.addEventListener("contextmenu", (event) => {
    if (pressed) event.preventDefault(); // a long touch is a press here
  });
  element.addEventListener("keydown", (event) => {
    if (event.key !== " " && event.key !== "Enter") return;
    event.preventDefault();
    if (!event.repeat) begin();
  });
  element.addEventListener("keyup", (event) => {
    if (event.key !== " " && event.key !== "Enter") return;
    event.preventDefault(); // or a click would follow
    end();
  });
  element.addEventListener("click", (event) => {
    if (event.detail !== 0) return;
    begin(); // a click without a pointer, as a screen reader makes it, is a short press
    end();
  });
}
