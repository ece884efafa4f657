// What charts over x share: axes with their names and units, figures with a true minus sign.

import { FONT } from "./canvas.js";
import { colour, minus } from "./dom.js";

// The two axes of a chart; `more` is of the first.
export function over(xName, yName, more = {}) {
  const values = (_, splits) => splits.map((value) => (value == null ? null : minus(String(Number(value.toPrecision(6))))));
  const axis = { stroke: colour("--ink"), grid: { stroke: colour("--line"), width: 1 }, font: FONT, labelFont: FONT, labelSize: 22, values };
  return [{ ...axis, size: 34, label: xName, ...more }, { ...axis, size: 56, label: yName }];
}

// Width of A4 between its margins, CSS pixels.
const PAPER = 660;

// On paper a chart is as wide as the paper.
export function printed(plot) {
  let { width, height } = plot;
  const gone = new AbortController();
  const when = (event, resize) => window.addEventListener(event, () => (plot.root.isConnected ? resize() : gone.abort()), { signal: gone.signal });
  when("beforeprint", () => {
    ({ width, height } = plot);
    plot.setSize({ width: Math.min(width, PAPER), height });
  });
  when("afterprint", () => plot.setSize({ width, height }));
}
