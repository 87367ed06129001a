/**
 * Files that the scope saves.
 */

import { h } from "./dom.js";

/**
 * @param {Blob} blob
 * @param {string} name
 */
function save(blob, name) {
  const address = URL.createObjectURL(blob);
  h("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 1000); // when the download has begun
}

/**
 * Save a text.
 * @param {string} text
 * @param {string} name
 * @param {string} type
 */
export function saveText(text, name, type) {
  save(new Blob([text], { type }), name);
}

/**
 * Save a picture as PNG, with twice as many points as the page.
 * @param {number} width
 * @param {number} height
 * @param {string} ground
 * @param {(context: CanvasRenderingContext2D) => void} draw
 * @returns {Promise<void>}
 */
export function saveImage(width, height, ground, draw) {
  const canvas = h("canvas", { width: 2 * width, height: 2 * height });
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  context.scale(2, 2);
  context.fillStyle = ground;
  context.fillRect(0, 0, width, height);
  draw(context);
  return new Promise((resolve, reject) => {
    canvas.toBlob((blob) => {
      if (!blob) return reject(new Error("The browser cannot create a picture of this size."));
      save(blob, "scope.png");
      resolve();
    }, "image/png");
  });
}
