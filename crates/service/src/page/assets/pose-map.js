// The poses of a cycle over two rotary axes, filling while they are read.

import { drawing } from "./canvas.js";
import { colour, el } from "./dom.js";
import { grid, labelWidth, nearest, stations } from "./heat-map.js";

const EDGE = { top: 22, right: 6, bottom: 22 };
const [WIDEST, LOWEST, HIGHEST] = [32, 18, 28];

// One map for each setup; a pose that was read is filled, the next one framed.
export function poseMap({ axes, setups, poses }) {
  const rows = stations(poses.map((pose) => pose.at_deg[0]));
  const columns = stations(poses.map((pose) => pose.at_deg[1]));
  const visits = poses.map((pose) => ({ setup: pose.setup, row: nearest(rows, pose.at_deg[0]), column: nearest(columns, pose.at_deg[1]) }));
  const cells = setups.map(() => rows.map(() => columns.map(() => [])));
  visits.forEach((visit, i) => cells[visit.setup][visit.row][visit.column].push(i));
  const left = labelWidth(rows);
  const wide = (width) => (width - left - EDGE.right) / columns.length;
  const high = (width) => Math.max(LOWEST, Math.min(HIGHEST, wide(width)));
  let [done, next] = [0, 0];
  const drawings = setups.map((_, k) => drawing({
    most: left + columns.length * WIDEST + EDGE.right,
    layout: (width) => EDGE.top + rows.length * high(width) + EDGE.bottom,
    paint: (ctx, width) => paint(ctx, k, wide(width), high(width)),
  }));
  const meanings = [["read", "read"], ["next", "next"], ["", "not read yet"]];
  // A cell of several passes fills with each of them.
  if (cells.flat(2).some((here) => here.length > 1)) meanings.splice(1, 0, ["in-part", "read in a part of its passes"]);
  const legend = el("ul", { class: "legend" }, meanings.map(([kind, text]) => el("li", {}, el("span", { class: `swatch ${kind}` }), text)));
  const figure = el("div", {}, legend, el("div", { class: "maps" }, setups.map((name, k) =>
    el("figure", { class: "map" }, el("figcaption", {}, `Setup ${name}`), drawings[k].canvas))));
  const count = (here) => here.filter((index) => index < done).length;

  function paint(ctx, k, w, h) {
    grid(ctx, { rows, columns, rowsName: axes[0], columnsName: axes[1], left, top: EDGE.top, w, h });
    rows.forEach((_, i) => columns.forEach((_, j) => {
      const here = cells[k][i][j];
      if (!here.length) return;
      const [x, y] = [left + j * w, EDGE.top + i * h];
      ctx.globalAlpha = 0.85 * (count(here) / here.length);
      ctx.fillStyle = colour("--blue");
      ctx.fillRect(x, y, w, h);
      ctx.globalAlpha = 1;
      const isNext = here.includes(next);
      ctx.strokeStyle = isNext ? colour("--orange") : colour("--line");
      ctx.lineWidth = isNext ? 3 : 1;
      ctx.strokeRect(x + 1, y + 1, w - 2, h - 2);
    }));
  }

  // Of a cycle that is over no pose is the next.
  function fill(now, nextNow = now) {
    [done, next] = [now, nextNow];
    setups.forEach((name, k) => {
      const all = cells[k].flat();
      const read = all.reduce((sum, here) => sum + count(here), 0);
      drawings[k].draw();
      drawings[k].canvas.setAttribute("aria-label", `Setup ${name}: ${read} of ${all.flat().length} poses read`);
    });
  }
  return { figure, poses: poses.length, fill };
}
