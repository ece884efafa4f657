// What-if pose by pose: the selected one in words, residuals over time, arrows, a table.

import { colour, el, fold, plain } from "./dom.js";
import { degrees, signed } from "./heat-map.js";

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
    const axes = linear.axes.map((axis, k) => `${axis.name} ${axis.rotary ? degrees(Number(point.position[k].toFixed(2))) : `${point.position[k].toFixed(1)} mm`}`).join(" ");
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
  const strokes = ["--blue", "--orange", "--soft", "--ink"];
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
    const axis = { stroke: colour("--ink"), grid: { stroke: colour("--line"), width: 1 } };
    const one = (name, k) => ({ label: `${name}, µm`, stroke: colour(strokes[k % strokes.length]), width: 0, paths: () => null, points: { show: true, size: 5 } });
    plot = new uPlot({
      width: Math.max(240, Math.min(1100, place.clientWidth || 600)), height: 240,
      scales: { x: { time: false } }, axes: [axis, axis], hooks: { draw: [markers] },
      series: [{ label: timed ? "time, s" : "pose" }, ...names.map(one)],
    }, data(takes), place);
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
  const scale = window.devicePixelRatio || 1;
  const [width, height, edge] = [760, 360, 44];
  const canvas = el("canvas", { width: width * scale, height: height * scale, role: "img" });
  canvas.style.maxWidth = `${width}px`;
  const legend = el("p", { class: "soft", role: "status" });
  const range = (k) => {
    const all = linear.points.map((point) => point.position[k]);
    const [from, to] = all.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
    return [from, to];
  };
  const [ra, rd] = [range(across.i), range(down.i)];
  const x = (point) => edge + 20 + ((point.position[across.i] - ra[0]) / (ra[1] - ra[0])) * (width - 2 * edge - 40);
  const y = (point) => height - edge - 20 - ((point.position[down.i] - rd[0]) / (rd[1] - rd[0])) * (height - 2 * edge - 40);
  let [takes, selected] = [null, []];
  // Pixels for a micrometre: from 0.1 to 1000.
  const pixels = () => 10 ** (Number(slider.value) / 25 - 1);
  function draw() {
    const ctx = canvas.getContext("2d");
    ctx.setTransform(scale, 0, 0, scale, 0, 0);
    ctx.clearRect(0, 0, width, height);
    const [a, b] = pairs[Number(pair.value)];
    const chosen = new Set(selected);
    linear.points.forEach((point, i) => {
      if (!takes[i]) return;
      const [right, up] = [value(i, a), value(i, b)];
      if (right == null || up == null) return;
      const [px, py] = [x(point), y(point)];
      ctx.strokeStyle = ctx.fillStyle = colour(chosen.has(i) ? "--orange" : "--blue");
      ctx.lineWidth = chosen.has(i) ? 3 : 1;
      ctx.beginPath();
      ctx.moveTo(px, py);
      ctx.lineTo(px + right * pixels(), py - up * pixels());
      ctx.stroke();
      ctx.fillRect(px - 1.5, py - 1.5, 3, 3);
    });
    ctx.fillStyle = ctx.strokeStyle = colour("--ink");
    ctx.font = "11px system-ui, sans-serif";
    ctx.fillText(`${across.name} ${degrees(ra[0])} to ${degrees(ra[1])}, to the right; ${down.name} ${degrees(rd[0])} to ${degrees(rd[1])}, up`, edge, height - 8);
    const um = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500].findLast((size) => size * pixels() <= 120) ?? 0.1;
    ctx.lineWidth = 3;
    ctx.beginPath();
    ctx.moveTo(edge, 14);
    ctx.lineTo(edge + um * pixels(), 14);
    ctx.stroke();
    ctx.fillText(`${um} µm`, edge, 30);
    // A CSS pixel is 0.2646 mm.
    const times = pixels() * 264.6;
    legend.textContent = `Magnification about ${plain(times)}; the bar is ${um} µm.`;
    canvas.setAttribute("aria-label", `Residual ${a} and ${b} as arrows, magnification about ${plain(times)}`);
  }
  slider.addEventListener("input", draw);
  pair.addEventListener("change", draw);
  // Begins with arrows of 40 pixels where the residual is largest.
  const largest = linear.points.reduce((most, _, i) => Math.max(most, ...names.map((name) => Math.abs(value(i, name) ?? 0))), 0);
  if (largest > 0) slider.value = String(Math.max(0, Math.min(100, 25 * (Math.log10(40 / largest) + 1))));
  const section = el("section", {}, el("h2", {}, "Residual as arrows"),
    el("p", { class: "row" }, el("label", {}, "Components", pair), el("label", {}, "Magnification", slider)), el("figure", { class: "map" }, canvas), legend);
  return {
    section,
    draw(takesNow, selectedNow) {
      [takes, selected] = [takesNow, selectedNow];
      draw();
    },
  };
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
      names.map((name) => figure(value(i, name))), timed ? el("td", { class: "n" }, point.time_s.toFixed(1)) : null,
      linear.axes.map((axis, k) => el("td", { class: "n" }, point.position[k].toFixed(axis.rotary ? 2 : 1))));
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
      el("table", {}, el("thead", {}, el("tr", {}, head.filter(Boolean).map((text) => el("th", { scope: "col" }, text)))), body)),
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
