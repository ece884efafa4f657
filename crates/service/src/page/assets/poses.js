// What-if pose by pose: the selected one in words, residuals over time, arrows, a table.

import { drawing } from "./canvas.js";
import { over, printed } from "./chart.js";
import { colour, decimal, el, fold, plain } from "./dom.js";
import { degrees, grid, labelWidth, nearest, signed, stations } from "./heat-map.js";

const ROWS = 50;
// Poses of a cell that are written out.
const SAID = 6;

// `select` is called with a pose.
export function posesOf(state, select) {
  const { linear, firstRow, residual } = state;
  const said = el("ul", { id: "selected", "aria-live": "polite" }, el("li", { class: "soft" }, "Point at a map or the chart, or take a row of the table."));
  const names = [...new Set(linear.setups.flatMap((setup) => setup.components))];
  const value = (i, name) => {
    const k = linear.setups[linear.points[i].setup].components.indexOf(name);
    return k < 0 ? null : residual[firstRow[i] + k];
  };
  const size = (i) => Math.hypot(...residual.subarray(firstRow[i], firstRow[i + 1]));
  const timed = linear.points.every((point) => point.time_s != null);
  const words = (i) => {
    const point = linear.points[i];
    const axes = linear.axes.map((axis, k) => `${axis.name} ${axis.rotary ? degrees(Number(point.position[k].toFixed(2))) : `${decimal(point.position[k], 1)} mm`}`).join(" ");
    const figures = names.map((name) => [name, value(i, name)]).filter(([, v]) => v != null).map(([name, v]) => `${name} ${signed(v)}`).join(", ");
    const at = point.time_s == null ? "" : `, at ${plain(point.time_s)} s`;
    return `Pose ${i + 1}, setup ${linear.setups[point.setup].name}${at}: ${figures} µm; ${axes}`;
  };
  let takes = linear.points.map(() => true);
  let selected = [];

  const chart = overTime(linear, names, value, timed, (i) => select(i));
  const arrows = arrowMap(state, names, value);
  const table = pages(linear, size, names, value, timed, (i) => select(i));

  return {
    said,
    chart: chart.place,
    arrows: arrows?.section ?? null,
    table: table.section,
    update(takesNow) {
      takes = takesNow;
      chart.draw(takes, selected);
      arrows?.draw(takes, selected);
      table.draw(takes, selected);
      if (selected.length) this.choose(selected);
    },
    choose(poses) {
      selected = poses.filter((i) => takes[i]);
      const more = selected.length > SAID ? [el("li", { class: "soft" }, `and ${selected.length - SAID} more`)] : [];
      said.replaceChildren(...(selected.length ? selected.slice(0, SAID).map((i) => el("li", {}, words(i))) : [el("li", {}, "Nothing was read there.")]), ...more);
      chart.mark(selected);
      arrows?.draw(takes, selected);
      table.mark(selected);
    },
  };
}

function overTime(linear, names, value, timed, select) {
  const place = el("div", { class: "chart" });
  const x = linear.points.map((point, i) => (timed ? point.time_s : i + 1));
  // uPlot wants x in order.
  const order = x.map((_, i) => i).sort((a, b) => x[a] - x[b]);
  const strokes = ["--blue", "--orange", "--ink", "--grey"];
  let plot = null;
  let marks = [];
  const data = (takes) => [order.map((i) => x[i]), ...names.map((name) => order.map((i) => (takes[i] ? value(i, name) : null)))];
  const markers = (u) => {
    u.ctx.save();
    u.ctx.strokeStyle = colour("--ink");
    u.ctx.lineWidth = 2;
    marks.slice(0, 20).forEach((i) => {
      const at = u.valToPos(x[i], "x", true);
      u.ctx.beginPath();
      u.ctx.moveTo(at, u.bbox.top);
      u.ctx.lineTo(at, u.bbox.top + u.bbox.height);
      u.ctx.stroke();
    });
    u.ctx.restore();
  };
  const make = (takes) => {
    const one = (name, k) => {
      const stroke = colour(strokes[k % strokes.length]);
      return { label: `${name}, µm`, stroke, width: 0, paths: () => null, points: { show: true, size: 5, fill: stroke } };
    };
    plot = new uPlot({
      width: Math.max(240, Math.min(1100, place.clientWidth || 600)), height: 260,
      scales: { x: { time: false } }, axes: over(timed ? "time, s" : "pose", "residual, µm"), hooks: { draw: [markers] },
      series: [{ label: timed ? "time, s" : "pose" }, ...names.map(one)],
    }, data(takes), place);
    printed(plot);
    plot.over.addEventListener("click", () => plot.cursor.idx != null && select(order[plot.cursor.idx]));
  };
  return {
    place: el("section", {}, el("h2", {}, timed ? "Residual over time" : "Residual, pose after pose"), place),
    draw(takes, selected) {
      marks = selected;
      if (plot) plot.setData(data(takes));
      else requestAnimationFrame(() => (plot ? plot.setData(data(takes)) : make(takes)));
    },
    mark(selected) {
      marks = selected;
      plot?.redraw(false, false);
    },
  };
}

// Two components of each pose as an arrow from its place over the rotary axes.
function arrowMap({ linear, rotary }, names, value) {
  const moved = rotary.filter(({ i }) => linear.points.some((point) => point.position[i] !== linear.points[0].position[i]));
  if (moved.length < 2 || names.length < 2) return null;
  const spread = ({ i }) => new Set(linear.points.map((point) => point.position[i].toFixed(2))).size;
  const [down, across] = moved.sort((a, b) => spread(a) - spread(b));
  const pairs = names.flatMap((a, k) => names.slice(k + 1).map((b) => [a, b]));
  const pair = el("select", { id: "plane" }, pairs.map(([a, b], k) => el("option", { value: k }, `${a} to the right, ${b} up`)));
  const slider = el("input", { id: "magnification", type: "range", min: "0", max: "100", value: "50" });
  const [rows, columns] = [down, across].map(({ i }) => stations(linear.points.map((point) => point.position[i])));
  const left = labelWidth(rows);
  const edge = { top: 44, right: 6, bottom: 22 };
  const wide = (width) => (width - left - edge.right) / columns.length;
  const high = (width) => Math.max(26, Math.min(44, wide(width)));
  const { canvas, draw } = drawing({ most: 760, layout: (width) => edge.top + rows.length * high(width) + edge.bottom, paint });
  const legend = el("p", { class: "soft", role: "status" });
  const where = linear.points.map((point) => [nearest(rows, point.position[down.i]), nearest(columns, point.position[across.i])]);
  let [takes, selected] = [null, []];
  // Pixels for a micrometre: from 0.1 to 1000.
  const pixels = () => 10 ** (Number(slider.value) / 25 - 1);
  function paint(ctx, width) {
    if (!takes) return;
    const [w, h] = [wide(width), high(width)];
    const [a, b] = pairs[Number(pair.value)];
    const chosen = new Set(selected);
    linear.points.forEach((_, i) => {
      if (!takes[i]) return;
      const [right, up] = [value(i, a), value(i, b)];
      if (right == null || up == null) return;
      const [px, py] = [left + (where[i][1] + 0.5) * w, edge.top + (where[i][0] + 0.5) * h];
      ctx.strokeStyle = ctx.fillStyle = colour(chosen.has(i) ? "--orange" : "--blue");
      ctx.lineWidth = chosen.has(i) ? 3 : 1.5;
      ctx.beginPath();
      ctx.moveTo(px, py);
      ctx.lineTo(px + right * pixels(), py - up * pixels());
      ctx.stroke();
      ctx.fillRect(px - 2, py - 2, 4, 4);
    });
    grid(ctx, { rows, columns, rowsName: down.name, columnsName: across.name, left, top: edge.top, w, h });
    const um = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500].findLast((size) => size * pixels() <= 120) ?? 0.1;
    ctx.strokeStyle = colour("--ink");
    ctx.lineWidth = 3;
    ctx.beginPath();
    ctx.moveTo(left, 12);
    ctx.lineTo(left + um * pixels(), 12);
    ctx.stroke();
    ctx.textAlign = "left";
    ctx.fillText(`${um} µm`, left + um * pixels() + 8, 12);
    // A CSS pixel is 0.2646 mm.
    const times = rounded(pixels() * 264.6);
    legend.textContent = `Magnification about ${times}; the bar is ${um} µm. An arrow begins at the place of its pose.`;
    canvas.setAttribute("aria-label", `Residual ${a} and ${b} as arrows, magnification about ${times}`);
  }
  slider.addEventListener("input", draw);
  pair.addEventListener("change", draw);
  // Begins with arrows of 40 pixels where the residual is largest.
  const largest = linear.points.reduce((most, _, i) => Math.max(most, ...names.map((name) => Math.abs(value(i, name) ?? 0))), 0);
  if (largest > 0) slider.value = String(Math.max(0, Math.min(100, 25 * (Math.log10(40 / largest) + 1))));
  const section = el("section", {}, el("h2", {}, "Residual as arrows"),
    el("p", { class: "row" }, el("label", {}, "Components", pair), el("label", {}, "Magnification", slider)), el("figure", { class: "map wide" }, canvas), legend);
  return {
    section,
    draw(takesNow, selectedNow) {
      [takes, selected] = [takesNow, selectedNow];
      draw();
    },
  };
}

// Two digits: the size of a screen is not known better.
function rounded(value) {
  const digit = 10 ** Math.max(0, Math.floor(Math.log10(value)) - 1);
  return String(Math.round(value / digit) * digit);
}

// Every pose, fifty a page, the largest residual or the first one first.
function pages(linear, size, names, value, timed, select) {
  const body = el("tbody");
  const order = el("select", { id: "order" }, el("option", { value: "size" }, "the largest residual first"), el("option", { value: "taken" }, "as they were taken"));
  const where = el("span", { role: "status" });
  const earlier = el("button", { type: "button" }, "Earlier");
  const later = el("button", { type: "button" }, "Later");
  let [list, page, chosen, takes] = [[], 0, new Set(), []];
  const head = ["pose", "setup", ...names.map((name) => `${name}, µm`), timed ? "time, s" : null, ...linear.axes.map(({ name, rotary }) => `${name}, ${rotary ? "°" : "mm"}`)];
  const row = (i) => {
    const point = linear.points[i];
    const pick = el("button", { type: "button" }, String(i + 1));
    pick.addEventListener("click", () => select(i));
    const figure = (v) => el("td", { class: "n" }, v == null ? "—" : signed(v));
    return el("tr", chosen.has(i) ? { "aria-current": "true", class: "chosen" } : {}, el("td", {}, pick), el("td", {}, linear.setups[point.setup].name),
      names.map((name) => figure(value(i, name))), timed ? el("td", { class: "n" }, decimal(point.time_s, 1)) : null,
      linear.axes.map((axis, k) => el("td", { class: "n" }, decimal(point.position[k], axis.rotary ? 2 : 1))));
  };
  function fill() {
    page = Math.max(0, Math.min(page, Math.ceil(list.length / ROWS) - 1));
    const shown = list.slice(page * ROWS, (page + 1) * ROWS);
    body.replaceChildren(...shown.map(row));
    where.textContent = list.length ? `${page * ROWS + 1} to ${page * ROWS + shown.length} of ${list.length} poses` : "no pose";
    earlier.disabled = page === 0;
    later.disabled = (page + 1) * ROWS >= list.length;
  }
  function sort() {
    list = linear.points.map((_, i) => i).filter((i) => takes[i]);
    if (order.value === "size") {
      const sizes = list.map(size);
      const rank = list.map((_, k) => k).sort((a, b) => sizes[b] - sizes[a]);
      list = rank.map((k) => list[k]);
    }
    fill();
  }
  order.addEventListener("change", () => {
    page = 0;
    sort();
  });
  earlier.addEventListener("click", () => {
    page -= 1;
    fill();
  });
  later.addEventListener("click", () => {
    page += 1;
    fill();
  });
  const section = fold("Every pose", () => [
    el("p", { class: "row" }, el("label", {}, "Order", order), earlier, later, where),
    el("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "Residual of poses" },
      el("table", {}, el("thead", {}, el("tr", {}, head.filter(Boolean).map((text, k) => el("th", { scope: "col", class: k > 1 && "n" }, text)))), body)),
  ]);
  return {
    section,
    draw(takesNow, selected) {
      [takes, chosen] = [takesNow, new Set(selected)];
      sort();
    },
    mark(selected) {
      chosen = new Set(selected);
      const at = selected.length === 1 ? list.indexOf(selected[0]) : -1;
      if (at >= 0) page = Math.floor(at / ROWS);
      fill();
    },
  };
}
