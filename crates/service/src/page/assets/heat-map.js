// A map over two rotary axes: orange where the value is positive, blue where it is negative, hatched where nothing was read.

import { colour, el, plain } from "./dom.js";

const CELL = 28;
const EDGE = { left: 52, top: 8, right: 8, bottom: 40 };

// `onPoint` is told the cell that is pointed at or reached by arrow keys.
export function heatMap({ title, rows, columns, rowsName, columnsName, unit = "µm", onPoint = () => {} }) {
  const width = EDGE.left + columns.length * CELL + EDGE.right;
  const height = EDGE.top + rows.length * CELL + EDGE.bottom;
  const scale = window.devicePixelRatio || 1;
  const canvas = el("canvas", { width: width * scale, height: height * scale, role: "img", tabindex: "0" });
  canvas.style.maxWidth = `${width * 1.6}px`;
  const under = el("p", { class: "soft" }, "Point at a cell, or use the arrow keys, to read its value.");
  const scaleLine = el("span", {});
  const figure = el("figure", { class: "map" }, el("figcaption", {}, title, ". ", scaleLine), canvas, under);
  let values = [];
  let limit = 1;
  let marked = null;

  function draw() {
    const ctx = canvas.getContext("2d");
    ctx.setTransform(scale, 0, 0, scale, 0, 0);
    ctx.clearRect(0, 0, width, height);
    ctx.font = "11px system-ui, sans-serif";
    ctx.textBaseline = "middle";
    rows.forEach((row, i) => {
      const y = EDGE.top + i * CELL;
      ctx.fillStyle = colour("--ink");
      ctx.textAlign = "right";
      if (rows.length < 20 || i % 3 === 0) ctx.fillText(degrees(row), EDGE.left - 6, y + CELL / 2);
      columns.forEach((_, j) => cell(ctx, EDGE.left + j * CELL, y, values[i]?.[j]));
    });
    ctx.fillStyle = colour("--ink");
    ctx.textAlign = "center";
    const widest = Math.max(...columns.map((column) => ctx.measureText(degrees(column)).width));
    const every = Math.ceil((widest + 8) / CELL);
    columns.forEach((column, j) => {
      if (j % every === 0) ctx.fillText(degrees(column), EDGE.left + (j + 0.5) * CELL, height - EDGE.bottom + 12);
    });
    ctx.fillText(columnsName, EDGE.left + (columns.length * CELL) / 2, height - 10);
    ctx.textAlign = "left";
    ctx.fillText(rowsName, 2, height - EDGE.bottom + 12);
    if (marked) {
      ctx.strokeStyle = colour("--ink");
      ctx.lineWidth = 3;
      ctx.strokeRect(EDGE.left + marked[1] * CELL + 1, EDGE.top + marked[0] * CELL + 1, CELL - 2, CELL - 2);
    }
  }

  function cell(ctx, x, y, value) {
    ctx.strokeStyle = colour("--line");
    ctx.lineWidth = 1;
    if (Number.isFinite(value)) {
      const share = Math.max(-1, Math.min(1, value / limit));
      ctx.globalAlpha = 1;
      ctx.fillStyle = colour("--paper");
      ctx.fillRect(x, y, CELL, CELL);
      ctx.globalAlpha = Math.abs(share);
      ctx.fillStyle = share > 0 ? colour("--orange") : colour("--blue");
      ctx.fillRect(x, y, CELL, CELL);
      ctx.globalAlpha = 1;
    } else {
      ctx.beginPath();
      ctx.moveTo(x, y + CELL);
      ctx.lineTo(x + CELL, y);
      ctx.stroke();
    }
    ctx.strokeRect(x + 0.5, y + 0.5, CELL - 1, CELL - 1);
  }

  canvas.addEventListener("pointermove", (event) => {
    const box = canvas.getBoundingClientRect();
    const j = Math.floor(((event.clientX - box.left) * (width / box.width) - EDGE.left) / CELL);
    const i = Math.floor(((event.clientY - box.top) * (height / box.height) - EDGE.top) / CELL);
    if (rows[i] !== undefined && columns[j] !== undefined) onPoint(i, j);
  });
  canvas.addEventListener("keydown", (event) => {
    const step = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] }[event.key];
    if (!step) return;
    event.preventDefault();
    const [i, j] = marked ? [marked[0] + step[0], marked[1] + step[1]] : [0, 0];
    if (rows[i] !== undefined && columns[j] !== undefined) onPoint(i, j);
  });

  function say() {
    if (!marked) return;
    const [i, j] = marked;
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
    // Frames a cell, the same in every map.
    mark(i, j) {
      marked = [i, j];
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

export const degrees = (value) => `${String(value).replace("-", "−")}°`;

export const signed = (value) => `${value < 0 ? "−" : "+"}${plain(Math.abs(value))}`;

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
