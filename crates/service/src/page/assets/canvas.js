// A drawing in CSS pixels: as wide as its place allows, its texts as large on a phone as on a screen.

import { el } from "./dom.js";

// Letters of 11 px at least can be read at arm's length; printed at 96 px an inch, 12 px are 9 pt.
export const FONT = "12px system-ui, sans-serif";

// `layout(width)` says how high the drawing is when it is so wide; `paint(ctx, width, height)` draws it.
export function drawing({ most, layout, paint, ...attributes }) {
  const canvas = el("canvas", { role: "img", ...attributes });
  canvas.style.maxWidth = `${most}px`;
  let width = 0;
  function draw() {
    const now = Math.min(most, Math.floor(canvas.parentElement?.clientWidth ?? 0));
    // Not on the page yet, or in a closed part: the observer calls again.
    if (now > 0) width = now;
    if (!width) return;
    const height = layout(width);
    const scale = window.devicePixelRatio || 1;
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(height * scale);
    // On paper it is smaller as a whole.
    canvas.style.aspectRatio = `${width} / ${height}`;
    const ctx = canvas.getContext("2d");
    ctx.setTransform(scale, 0, 0, scale, 0, 0);
    ctx.clearRect(0, 0, width, height);
    ctx.font = FONT;
    paint(ctx, width, height);
  }
  // Where the pointer is, in the drawing's pixels.
  const at = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top].map((pixels) => (pixels * width) / box.width);
  };
  new ResizeObserver(() => {
    const now = Math.min(most, Math.floor(canvas.parentElement?.clientWidth ?? 0));
    if (now !== width) draw();
  }).observe(canvas);
  return { canvas, draw, at };
}
