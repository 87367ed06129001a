/**
 * Return what a reader of this page cannot see: what is cut off, or runs out of its box or out of the page, and text that
 * hardly differs from what is behind it.  What scrolls by itself is not cut off, but the page as a whole must not.
 */
() => {
  const ROUNDING = 1; // px
  const PALE = 3; // the least contrast, as WCAG 2 counts it
  const found = new Set();
  const shown = (element) => element.checkVisibility({ visibilityProperty: true, opacityProperty: true });
  const scrolls = (element) => /auto|scroll/.test(getComputedStyle(element).overflowX);
  const flows = (element) => getComputedStyle(element).display.startsWith("inline");
  const called = (element) => {
    const text = element.textContent.trim().replace(/\s+/g, " ");
    return `${[element.localName, ...element.classList].join(".")} "${text.slice(0, 50)}"`;
  };

  const channels = (colour) => colour.match(/[\d.]+/g).map(Number);
  const light = (colour) => {
    const [r, g, b] = colour.map((one) => (one / 255 <= 0.04045 ? one / 255 / 12.92 : ((one / 255 + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const over = ([r, g, b, a = 1], behind) => [r, g, b].map((one, n) => one * a + behind[n] * (1 - a));
  const behind = (element) => {
    if (!element) return [255, 255, 255];
    const colour = channels(getComputedStyle(element).backgroundColor);
    return colour[3] === 0 ? behind(element.parentElement) : over(colour, behind(element.parentElement));
  };
  const contrast = (element) => {
    const paper = behind(element);
    const [dark, bright] = [light(paper), light(over(channels(getComputedStyle(element).color), paper))].sort((a, b) => a - b);
    return (bright + 0.05) / (dark + 0.05);
  };

  for (const folded of document.querySelectorAll("details")) folded.open = true;
  for (let around = document.querySelector("article") ?? document.body; around; around = around.parentElement) {
    if (getComputedStyle(around).overflowX === "visible") continue; // a heading may have a margin that nobody sees
    const wide = around.scrollWidth - around.clientWidth;
    if (wide > 0) found.add(`${around.localName}: ${wide} px of the page are beyond the window`);
  }
  for (const element of document.body.querySelectorAll("*")) {
    if (!(element instanceof HTMLElement) || element.clientWidth <= ROUNDING || !shown(element)) continue;
    const { overflowX, overflowY } = getComputedStyle(element);
    const wide = element.scrollWidth - element.clientWidth;
    const high = element.scrollHeight - element.clientHeight;
    if (wide > ROUNDING && /hidden|clip/.test(overflowX)) found.add(`${called(element)}: ${wide} px are cut off on the right`);
    if (high > ROUNDING && /hidden|clip/.test(overflowY)) found.add(`${called(element)}: ${high} px are cut off below`);
  }
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const range = document.createRange();
  while (texts.nextNode()) {
    const text = texts.currentNode;
    let box = text.parentElement;
    if (!text.data.trim() || !shown(box) || box.clientWidth === ROUNDING) continue; // as long as a screen reader's
    const contrasted = contrast(box);
    if (contrasted < PALE) found.add(`${called(box)}: contrast ${contrasted.toFixed(1)}`);
    while (flows(box)) box = box.parentElement;
    if (scrolls(box)) continue;
    range.selectNodeContents(text);
    const { right } = box.getBoundingClientRect(); // on the left, a first line may hang out
    const out = Math.max(...[...range.getClientRects()].map((rect) => rect.width && rect.right - right));
    if (out > ROUNDING) found.add(`${called(box)}: ${Math.round(out)} px run out of it`);
  }
  for (const image of document.images) {
    if (!image.naturalWidth) found.add(`${image.src}: no picture`);
    const out = image.getBoundingClientRect().right - image.parentElement.getBoundingClientRect().right;
    if (shown(image) && out > ROUNDING) found.add(`${image.src}: ${Math.round(out)} px run out of its place`);
  }
  return [...found];
}
