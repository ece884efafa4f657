// The poses of a cycle over two rotary axes, filling while they are read.

import { colour, el } from "./dom.js";
import { degrees, nearest, stations } from "./heat-map.js";

// One map for each setup; a pose that was read is filled, the next one framed.
export function poseMap({ axes, setups, poses }) {
  const rows = stations(poses.map((pose) => pose.at_deg[0]));
  const columns = stations(poses.map((pose) => pose.at_deg[1]));
  const visits = poses.map((pose) => ({ setup: pose.setup, row: nearest(rows, pose.at_deg[0]), column: nearest(columns, pose.at_deg[1]) }));
  const cells = setups.map(() => rows.map(() => columns.map(() => [])));
  visits.forEach((visit, i) => cells[visit.setup][visit.row][visit.column].push(i));
  const CELL = 22;
  const scale = window.devicePixelRatio || 1;
  const canvases = setups.map(() => {
    const [width, height] = [columns.length * CELL + 50, rows.length * CELL + 26];
    const canvas = el("canvas", { width: width * scale, height: height * scale, role: "img" });
    canvas.style.maxWidth = `${width * 1.4}px`;
    return { canvas, width, height };
  });
  const figure = el("div", { class: "maps" }, setups.map((name, k) =>
    el("figure", { class: "map" }, el("figcaption", {}, `Setup ${name}: ${axes[0]} down, ${axes[1]} across`), canvases[k].canvas)));
  function fill(done) {
    setups.forEach((name, k) => {
      const { canvas, width, height } = canvases[k];
      const ctx = canvas.getContext("2d");
      ctx.setTransform(scale, 0, 0, scale, 0, 0);
      ctx.clearRect(0, 0, width, height);
      ctx.font = "10px system-ui, sans-serif";
      let [read, all] = [0, 0];
      rows.forEach((row, i) => {
        const y = i * CELL;
        ctx.fillStyle = colour("--ink");
        ctx.fillText(degrees(row), 2, y + CELL / 2 + 3);
        columns.forEach((column, j) => {
          const here = cells[k][i][j];
          const taken = here.filter((index) => index < done).length;
          [read, all] = [read + taken, all + here.length];
          ctx.globalAlpha = here.length ? 0.85 * (taken / here.length) : 0;
          ctx.fillStyle = colour("--blue");
          ctx.fillRect(46 + j * CELL, y, CELL, CELL);
          ctx.globalAlpha = 1;
          ctx.strokeStyle = here.includes(done) ? colour("--orange") : colour("--line");
          ctx.lineWidth = here.includes(done) ? 3 : 1;
          ctx.strokeRect(46 + j * CELL + 1, y + 1, CELL - 2, CELL - 2);
        });
      });
      ctx.fillStyle = colour("--ink");
      const every = Math.ceil(columns.length / 8);
      columns.forEach((column, j) => j % every === 0 && ctx.fillText(degrees(column), 46 + j * CELL, height - 8));
      canvas.setAttribute("aria-label", `Setup ${name}: ${read} of ${all} poses read`);
    });
  }
  const map = { figure, poses: poses.length, filled: false };
  map.fill = (done) => {
    map.filled = true;
    fill(done);
  };
  return map;
}
