/**
 * Further helpers for elements: several attributes in one call, SVG, and buttons that change only the display.
 */

import { h } from "./dom.js";

const SVG = "http://www.w3.org/2000/svg";

/** @typedef {Record<string, string | number | boolean | null | undefined>} Attributes */

/**
 * Set attributes; `true` sets one without a value, `false`, null and undefined remove it.
 * @param {Element} element
 * @param {Attributes} attributes
 */
export function set(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === false || value === null || value === undefined) element.removeAttribute(name);
    else element.setAttribute(name, value === true ? "" : String(value));
  }
}

/**
 * Return a new element of SVG.
 * @template {keyof SVGElementTagNameMap} T
 * @param {T} tag
 * @param {Attributes} [attributes]
 * @returns {SVGElementTagNameMap[T]}
 */
export function svg(tag, attributes = {}) {
  const element = document.createElementNS(SVG, tag);
  set(element, attributes);
  return element;
}

/**
 * Return a button that changes only the display, so it also works on a read-only page.
 * @param {string} text
 * @param {() => void} click
 * @param {Record<string, unknown>} [attributes]
 * @returns {HTMLButtonElement}
 */
export function control(text, click, attributes = {}) {
  return h("button", { type: "button", click, ...attributes }, text);
}
