// A map over two rotary axes: orange where the value is positive, blue where it is negative, hatched where nothing was read.

import { drawing } from "./canvas.js";
import { colour, decimal, el, plain } from "./dom.js";

const EDGE = { top: 22, right: 6, bottom: 22 };
// Sides of a cell: no wider than a thumb, no lower than a line of text.
const WIDEST = 44;
const [LOWEST, HIGHEST] = [18, 30];

// `onPoint` is called with the cell that is pointed at, tapped or reached by arrow keys.
export function heatMap({ title, rows, columns, rowsName, columnsName, unit = "µm", onPoint = () => {} }) {
  const left = labelWidth(rows);
  const wide = (width) => (width - left - EDGE.right) / columns.length;
  const high = (width) => Math.max(LOWEST, Math.min(HIGHEST, wide(width)));
  const { canvas, draw, at } = drawing({
    most: left + columns.length * WIDEST + EDGE.right,
    layout: (width) => EDGE.top + rows.length * high(width) + EDGE.bottom,
    paint,
    tabindex: "0",
  });
  const under = el("p", { class: "soft" }, "Point at a cell, tap it, or use the arrow keys, to read its value.");
  const scaleLine = el("span", {});
  const figure = el("figure", { class: "map" }, el("figcaption", {}, title, ". ", scaleLine), canvas, under);
  let values = [];
  let limit = 1;
  // Cells of the selection.
  let marked = [];

  function paint(ctx, width, height) {
    const [w, h] = [wide(width), high(width)];
    grid(ctx, { rows, columns, rowsName, columnsName, left, top: EDGE.top, w, h });
    rows.forEach((_, i) => columns.forEach((_, j) => cell(ctx, left + j * w, EDGE.top + i * h, w, h, values[i]?.[j])));
    ctx.strokeStyle = colour("--ink");
    ctx.lineWidth = 3;
    marked.forEach(([i, j]) => ctx.strokeRect(left + j * w + 1, EDGE.top + i * h + 1, w - 2, h - 2));
  }

  function cell(ctx, x, y, w, h, value) {
    ctx.strokeStyle = colour("--line");
    ctx.lineWidth = 1;
    if (Number.isFinite(value)) {
      const share = Math.max(-1, Math.min(1, value / limit));
      ctx.globalAlpha = Math.abs(share);
      ctx.fillStyle = share > 0 ? colour("--orange") : colour("--blue");
      ctx.fillRect(x, y, w, h);
      ctx.globalAlpha = 1;
    } else {
      ctx.beginPath();
      ctx.moveTo(x, y + h);
      ctx.lineTo(x + w, y);
      ctx.stroke();
    }
    ctx.strokeRect(x + 0.5, y + 0.5, w - 1, h - 1);
  }

  const pick = (event) => {
    const [x, y] = at(event);
    const width = canvas.clientWidth;
    const j = Math.floor((x - left) / wide(width));
    const i = Math.floor((y - EDGE.top) / high(width));
    if (rows[i] !== undefined && columns[j] !== undefined) onPoint(i, j);
  };
  // A mouse that passes over selects; a finger taps, and its strokes scroll the page.
  canvas.addEventListener("pointermove", (event) => event.pointerType === "mouse" && pick(event));
  canvas.addEventListener("click", pick);
  canvas.addEventListener("keydown", (event) => {
    const step = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] }[event.key];
    if (!step) return;
    event.preventDefault();
    const [i, j] = marked.length ? [marked[0][0] + step[0], marked[0][1] + step[1]] : [0, 0];
    if (rows[i] !== undefined && columns[j] !== undefined) onPoint(i, j);
  });

  function say() {
    if (!marked.length) return;
    if (marked.length > 1) {
      under.textContent = `${marked.length} cells are selected.`;
      return;
    }
    const [[i, j]] = marked;
    const value = values[i]?.[j];
    const figures = Number.isFinite(value) ? `${signed(value)} ${unit}` : "nothing was read";
    under.textContent = `${rowsName} ${degrees(rows[i])}, ${columnsName} ${degrees(columns[j])}: ${figures}`;
  }

  return {
    figure,
    show(now, limitNow) {
      [values, limit] = [now, limitNow || 1];
      canvas.setAttribute("aria-label", `${title}: ${summary(rows, columns, values, rowsName, columnsName, unit)}`);
      scaleLine.textContent = `Full colour: ${plain(limit)} ${unit}; orange positive, blue negative.`;
      draw();
      say();
    },
    // Frames cells, the same in every map.
    mark(cells) {
      marked = cells;
      draw();
      say();
    },
  };
}

function summary(rows, columns, values, rowsName, columnsName, unit) {
  let largest = null;
  values.forEach((row, i) => row.forEach((value, j) => {
    if (Number.isFinite(value) && (!largest || Math.abs(value) > Math.abs(largest.value))) largest = { value, i, j };
  }));
  if (!largest) return "nothing was read";
  return `largest ${signed(largest.value)} ${unit} at ${rowsName} ${degrees(rows[largest.i])}, ${columnsName} ${degrees(columns[largest.j])}`;
}

// Room for the longest name of a row.
export const labelWidth = (rows) => 10 + 8 * Math.max(...rows.map((row) => degrees(row).length));

// Names of rows and columns around cells; no name runs into the next.
export function grid(ctx, { rows, columns, rowsName, columnsName, left, top, w, h }) {
  ctx.fillStyle = colour("--ink");
  ctx.textBaseline = "middle";
  ctx.textAlign = "left";
  ctx.fillText(`${rowsName} down, ${columnsName} across`, left, top - 11);
  ctx.textAlign = "right";
  const everyRow = Math.ceil(14 / h);
  rows.forEach((row, i) => i % everyRow === 0 && ctx.fillText(degrees(row), left - 6, top + (i + 0.5) * h));
  ctx.textAlign = "center";
  const widest = Math.max(...columns.map((column) => ctx.measureText(degrees(column)).width));
  const every = Math.ceil((widest + 8) / w);
  columns.forEach((column, j) => j % every === 0 && ctx.fillText(degrees(column), left + (j + 0.5) * w, top + rows.length * h + 12));
}

export const degrees = (value) => `${String(value).replace("-", "−")}°`;

// A residual of one reading: no more than hundredths of a micrometre mean anything.
export function signed(value) {
  const size = Math.abs(value) < 9.995 ? decimal(Math.abs(value), 2) : plain(Math.abs(value));
  return /[1-9]/.test(size) ? `${value < 0 ? "−" : "+"}${size}` : size;
}

// Positions at which an axis was read; sectors of 10° where it was read while turning, as in the report.
export function stations(values) {
  const distinct = (grid) => [...new Set(values.map((value) => Math.round(value / grid)))].sort((a, b) => a - b).map((n) => Number((n * grid).toFixed(2)));
  const fine = distinct(0.01);
  return fine.length > 36 ? distinct(10) : fine;
}

export function nearest(sorted, value) {
  let best = 0;
  for (let i = 1; i < sorted.length; i++) if (Math.abs(sorted[i] - value) < Math.abs(sorted[best] - value)) best = i;
  return best;
}
