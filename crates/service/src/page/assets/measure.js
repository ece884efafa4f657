// What is measured now: probes in their range, devices with their remedy, the poses of the cycle filling a map.

import { colour, el } from "./dom.js";
import { degrees, nearest, stations } from "./heat-map.js";

let parts = null;

export async function make(page) {
  const { status } = page;
  if (status.serves === "recordings") {
    parts = null;
    return [
      el("h1", {}, "Nothing is measured here"),
      el("p", {}, "This page shows recordings. The service measures: trunnion daemon --config FILE, or for one cycle: trunnion record CYCLE --config FILE."),
    ];
  }
  parts = {
    headline: el("h1", { id: "cycle-state" }, "Waiting for the cycle"),
    say: el("p", { class: "lead", role: "status" }),
    progress: el("progress", { max: "1", value: "0", "aria-label": "Poses read" }),
    left: el("p", {}),
    probes: el("div", { class: "two" }),
    devices: el("ul", { class: "steps" }),
    axes: el("p", {}),
    map: status.cycle ? poseMap(status.cycle) : null,
  };
  parts.values = el("section", {}, el("h2", {}, "Probes"), parts.probes, el("h2", {}, "Axes"), parts.axes);
  changed(page, "all");
  return [
    parts.headline, parts.say, parts.progress, parts.left,
    status.cycle ? el("h2", {}, `Poses of ${status.cycle.name}`) : null,
    parts.map?.figure,
    parts.values,
    el("h2", {}, "Devices"), parts.devices,
  ].filter(Boolean);
}

export function changed(page, topic) {
  if (!parts) return;
  const { cycle, status, live } = page.topics;
  if (topic === "all" || topic === "cycle") showCycle(cycle);
  if (topic === "all" || topic === "live" || topic === "status") {
    showProbes(live);
    showDevices(live, status);
  }
}

function showCycle(cycle) {
  const state = cycle?.state;
  const words = {
    measuring: "Measuring", analysing: "The cycle is over and is being analysed", done: "The cycle is done",
    failed: "The cycle failed", refused: "No cycle belongs to this program",
  };
  parts.headline.textContent = words[state] ?? "Waiting for the cycle";
  const total = cycle?.total ?? 0;
  const done = state === "measuring" ? (cycle.done ?? 0) : 0;
  const over = state === "done" || state === "analysing";
  const whole = over && cycle.missing === 0 && cycle.unsettled === 0;
  if (total) parts.progress.max = total;
  if (over) parts.progress.value = parts.progress.max;
  else parts.progress.value = done;
  // The map is of one cycle; what is done stays on it.
  if (whole) parts.map?.fill(Infinity);
  else if (!over && (!total || total === parts.map?.poses)) parts.map?.fill(done);
  else if (!parts.map?.filled) parts.map?.fill(0);
  const left = cycle?.seconds_left;
  const texts = [];
  if (state === "measuring" && total) texts.push(`${done} of ${total} poses`);
  if (state === "measuring" && left != null) texts.push(`about ${Math.ceil(left)} s left`);
  if (over) texts.push(cycle.run, cycle.ended);
  if (over && cycle.read != null) texts.push(`${cycle.read} read, ${cycle.unsettled} unsettled, ${cycle.missing} missing, ${cycle.gaps} gaps`);
  if (cycle?.why) texts.push(cycle.why);
  parts.left.textContent = texts.filter(Boolean).join("; ");
}

function showProbes(live) {
  parts.values.hidden = !live;
  parts.say.textContent = live?.say ?? "";
  const probes = live?.probes ?? [];
  if (!probes.length) {
    parts.probes.replaceChildren(el("p", { class: "soft" }, "No live values yet."));
  } else {
    parts.probes.replaceChildren(...probes.map(bar));
  }
  const axes = live?.axes ?? [];
  parts.axes.textContent = axes.length ? axes.map(({ name, value, unit }) => `${name} ${value.toFixed(3)} ${unit === "deg" ? "°" : unit}`).join("   ") : "The controller reports no position yet.";
}

function bar({ name, value_mm: value, range_mm: range, zone, say }) {
  const known = value != null && range;
  const good = zone === "centre" || zone === "inside" || zone === "unknown";
  return el("div", { class: "card" },
    el("h3", {}, name, " ", el("span", { class: `state ${good ? "ok" : "bad"}` }, zone.replace("-", " "))),
    known ? el("meter", { min: range[0], max: range[1], value, "aria-label": `${name} in its range` }) : null,
    el("p", { class: "falls" }, value == null ? "—" : `${value.toFixed(4)} mm`),
    say ? el("p", {}, say) : null);
}

function showDevices(live, status) {
  const remedies = Object.fromEntries((live?.devices ?? []).map((device) => [device.name, device]));
  const devices = Object.entries(status?.devices ?? {});
  const row = ([name, device]) => {
    const good = device.state === "Streaming";
    const remedy = remedies[name]?.remedy ?? (good ? null : device.last_end);
    return el("li", {},
      el("span", { class: "name" }, el("b", {}, name), device.identity ? ` ${device.identity}` : ""),
      el("span", { class: `state ${good ? "ok" : "bad"}` }, device.state),
      device.lost_messages ? el("span", {}, `${device.lost_messages} messages lost`) : null,
      remedy ? el("span", {}, remedy) : null);
  };
  parts.devices.replaceChildren(...(devices.length ? devices.map(row) : [el("li", {}, "No device yet.")]));
}

// One map for each setup; a pose that was read is filled, the next one framed.
function poseMap({ axes, setups, poses }) {
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
