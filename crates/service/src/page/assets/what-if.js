// Effects on and off: the residual is that of the model less what each set chosen takes off it.

import * as calls from "./calls.js";
import { el, fold, notice, plain } from "./dom.js";
import { heatMap, nearest, stations } from "./heat-map.js";
import { factors } from "./joint.js";
import { residualBars } from "./residual-bars.js";
import { overlay } from "./overlay.js";
import { posesOf } from "./poses.js";

// Expressions that were fitted on this page: of one run and one model.
const typed = { of: "", solutions: [] };

export async function make(page) {
  if (!page.run) return [el("h1", {}, "What if"), el("p", {}, "There is no recording yet.")];
  notice(`Fitting ${page.run} with and without each effect …`);
  const linear = await calls.linear(page.run);
  notice("");
  const of = JSON.stringify([page.run, linear.solutions.map(({ changed, rms_um: um }) => [changed, um])]);
  if (typed.of !== of) Object.assign(typed, { of, solutions: [] });
  linear.solutions.push(...typed.solutions);
  const state = prepare(linear);
  const figure = el("p", { class: "big", role: "status", id: "rms" });
  const remark = el("p", { class: "soft" });
  // One selection for all plots: a cell of the maps, a pose, or a place of the two curves.
  const choose = (chosen, cells) => {
    maps?.drawn.forEach((map) => map.mark(cells));
    curves?.mark(chosen);
    poses.choose(chosen);
  };
  const atCell = (i, j) => choose(linear.points.map((_, k) => k).filter((k) => maps.where[k][0] === i && maps.where[k][1] === j), [[i, j]]);
  const atPoses = (chosen) => choose(chosen, maps ? [...new Map(chosen.map((k) => [String(maps.where[k]), maps.where[k]])).values()] : []);
  const maps = mapsOf(state, atCell);
  const poses = posesOf(state, (k) => atPoses([k]));
  const bars = residualBars(state);
  const curves = overlay(state, atPoses);
  const update = () => compute(state, { figure, remark, maps, poses, bars, curves });
  const parts = [
    el("h1", {}, "What if"),
    el("p", {}, "Switch effects on and off: residual and maps follow at once. Nothing is changed in the model."),
    choices("Effects", linear.solutions.slice(1).map((solution, i) => ({
      text: solution.title, checked: solution.without || state.on[i], value: solution.changed,
      set: (on) => (state.on[i] = on !== solution.without),
    })), update),
    el("div", { class: "two" },
      choices("Setups", linear.setups.map((setup, i) => ({ text: setup.name, checked: true, value: setup.name, set: (on) => (state.setups[i] = on) })), update),
      choices("Directions", state.directions.map((name, i) => ({ text: name, checked: true, value: name, set: (on) => (state.ways[i] = on) })), update)),
    el("h2", {}, "Residual, rms"), figure, remark, bars.place,
    el("div", { class: "maps" }, maps ? maps.drawn.map((map) => map.figure) : el("p", {}, "No map: fewer than two rotary axes moved.")),
    isAlongAxes(linear) ? el("p", { class: "soft" }, "x, y, z are the axes of the instrument. Those of a nest on the table turn with it: there they are table X, Y, Z of the Result.") : null,
    curves?.section,
    el("h2", {}, "The selected poses"), poses.said,
    poses.chart, poses.arrows, poses.table,
    fold("Try an expression", () => editor(page)),
  ];
  update();
  return parts.filter(Boolean);
}

const isAlongAxes = ({ setups }) => setups.some(({ components }) => components.includes("x"));

function choices(title, items, update) {
  if (!items.length) return el("fieldset", { class: "choices" }, el("legend", {}, title), el("p", {}, "There is none to switch."));
  const choice = ({ text, checked, value, set }) => {
    const box = el("input", { type: "checkbox", checked, value });
    box.addEventListener("change", () => {
      set(box.checked);
      update();
    });
    return el("label", { class: "choice" }, box, text);
  };
  return el("fieldset", { class: "choices" }, el("legend", {}, title), items.map(choice));
}

function prepare(linear) {
  const [model, ...changes] = linear.solutions;
  const deltas = changes.map(({ change_um }) => Float64Array.from(change_um));
  const rotary = linear.axes.map((axis, i) => ({ ...axis, i })).filter((axis) => axis.rotary);
  const way = (point) => rotary.map(({ name, i }) => (point.direction[i] > 0 ? `${name} forward` : point.direction[i] < 0 ? `${name} back` : null)).filter(Boolean).join(", ") || "no direction";
  const directions = [...new Set(linear.points.map(way))];
  const firstRow = [0];
  linear.points.forEach((point, i) => firstRow.push(firstRow[i] + linear.setups[point.setup].components.length));
  return {
    linear, model, changes, deltas, firstRow, directions, rotary,
    way: linear.points.map((point) => directions.indexOf(way(point))),
    on: changes.map((change) => typed.solutions.includes(change)),
    setups: linear.setups.map(() => true),
    ways: directions.map(() => true),
    residual: Float64Array.from(linear.residual_um),
  };
}

function mapsOf({ linear, rotary }, onPoint) {
  const moved = rotary.map((axis) => ({ ...axis, at: stations(linear.points.map((point) => point.position[axis.i])) })).filter((axis) => axis.at.length > 1);
  if (moved.length < 2) return null;
  moved.sort((a, b) => a.at.length - b.at.length);
  const [tilting, turning] = moved;
  const names = [...new Set(linear.setups.flatMap((setup) => setup.components))];
  const where = linear.points.map((point) => [nearest(tilting.at, point.position[tilting.i]), nearest(turning.at, point.position[turning.i])]);
  const drawn = names.map((name) => heatMap({
    title: `Residual of component ${name} of the readings, measured − predicted, mean over setups and directions`,
    rows: tilting.at, columns: turning.at, rowsName: tilting.name, columnsName: turning.name, onPoint,
  }));
  return { names, drawn, where, rows: tilting.at.length, columns: turning.at.length, limit: 0 };
}

function compute(state, shown) {
  const { linear, model, changes, deltas, firstRow, residual } = state;
  residual.set(linear.residual_um);
  const chosen = changes.map((_, i) => i).filter((i) => state.on[i]);
  const exact = chosen.length === 0 ? model : chosen.length === 1 ? changes[chosen[0]] : null;
  // Of several fits the best says which points belong to none of them: it is the one to be better than.
  const best = chosen.reduce((least, i) => (changes[i].rms_um < least.rms_um ? changes[i] : least), changes[chosen[0]] ?? model);
  const excluded = new Set(best.excluded);
  const by = exact ? new Float64Array(changes.length).fill(1) : factors(linear.residual_um, changes, deltas, chosen, rowsWithout(excluded, state));
  for (const i of chosen) for (let row = 0; row < residual.length; row++) residual[row] -= by[i] * deltas[i][row];
  const takes = linear.points.map((point, i) => state.setups[point.setup] && state.ways[state.way[i]]);
  let [sum, count] = [0, 0];
  linear.points.forEach((_, i) => {
    if (!takes[i] || excluded.has(i)) return;
    for (let row = firstRow[i]; row < firstRow[i + 1]; row++) {
      sum += residual[row] ** 2;
      count += 1;
    }
  });
  const rms = Math.sqrt(sum / count);
  shown.figure.textContent = count ? `${plain(rms)} µm` : "—";
  shown.figure.dataset.um = rms;
  const whole = takes.every(Boolean);
  shown.remark.textContent = !whole ? "Of the chosen setups and directions."
    : exact ? `The fit of this set of effects gives ${exact.rms}.`
    : several(chosen.map((i) => changes[i]));
  if (shown.maps) drawMaps(state, takes, excluded, shown.maps);
  shown.bars.draw(rms, chosen);
  shown.curves?.draw(takes, excluded);
  shown.poses.update(takes);
}

function rowsWithout(excluded, { linear, firstRow }) {
  const rows = [];
  linear.points.forEach((_, i) => {
    if (!excluded.has(i)) for (let row = firstRow[i]; row < firstRow[i + 1]; row++) rows.push(row);
  });
  return rows;
}

// What the figure of several changes is, next to the fit of all of them.
function several(chosen) {
  const out = chosen.filter(({ without }) => without).length;
  if (!out) return "Several effects at once: the pattern of each as fitted alone, their sizes fitted together. A fit of all of them gives about this, or less.";
  if (out === chosen.length) return "Several effects switched off at once: estimated from switching off each alone. A fit without all of them gives about this, or more.";
  return "Effects switched on and off at once: estimated from the fit of each alone. One switched on that can stand in for one switched off leaves less in a fit.";
}

function drawMaps({ linear, firstRow, residual }, takes, excluded, maps) {
  const all = maps.names.map((name) => {
    const sums = Array.from({ length: maps.rows }, () => new Float64Array(maps.columns));
    const counts = Array.from({ length: maps.rows }, () => new Float64Array(maps.columns));
    linear.points.forEach((point, i) => {
      const k = linear.setups[point.setup].components.indexOf(name);
      if (!takes[i] || excluded.has(i) || k < 0) return;
      const [row, column] = maps.where[i];
      sums[row][column] += residual[firstRow[i] + k];
      counts[row][column] += 1;
    });
    return sums.map((row, i) => Array.from(row, (value, j) => (counts[i][j] ? value / counts[i][j] : NaN)));
  });
  const largest = Math.max(...all.flat(2).filter(Number.isFinite).map(Math.abs), 0);
  // The scale grows and stays: what is switched off and on can be compared.
  maps.limit = Math.max(maps.limit, largest);
  maps.drawn.forEach((map, k) => map.show(all[k], maps.limit));
}

function editor(page) {
  const site = el("input", { value: "axis:B", id: "site" });
  const component = el("select", { id: "component" }, ["dx", "dy", "dz", "ea", "eb", "ec"].map((name) => el("option", {}, name)));
  const expression = el("input", { value: "k*sin(2*B)", id: "expression", size: "40", spellcheck: "false" });
  const answer = el("p", { role: "status" });
  const command = el("p", { class: "formula" });
  const put = el("button", { type: "button", disabled: true }, "Fit it and switch it on");
  put.addEventListener("click", async () => {
    put.disabled = true;
    answer.textContent = "Fitting the model with it …";
    try {
      const [site, component, expression] = values();
      const { solutions } = await calls.linearWith(page.run, { site, component, expression });
      // Each that was typed is a change of its own.
      const fitted = { ...solutions[1], changed: solutions[1].title };
      typed.solutions = typed.solutions.filter((one) => one.changed !== fitted.changed);
      typed.solutions.push(fitted);
      await page.show();
    } catch (failure) {
      answer.textContent = failure.message;
    }
  });
  const values = () => [site, component, expression].map(({ value }) => value);
  let asked = 0;
  const check = async () => {
    const number = ++asked;
    put.disabled = true;
    await new Promise((later) => setTimeout(later, 250));
    if (number !== asked) return;
    try {
      const [site, component, expression] = values();
      const checked = await calls.formula({ run: page.run, site, component, expression });
      if (number !== asked) return;
      put.disabled = !checked.valid;
      answer.textContent = checked.valid ? `It can be fitted. Parameters: ${[...checked.parameters, ...checked.shapes].join(", ")}.` : checked.problem;
      command.textContent = checked.valid ? `trunnion compare ${page.run}.mcap --try formula:mine --site ${site} --component ${component} --expression "${expression}"` : "";
    } catch (failure) {
      answer.textContent = failure.message;
    }
  };
  [site, component, expression].forEach((input) => input.addEventListener("input", check));
  check();
  return [
    el("p", {}, "Over A B C in rad, X Y Z in mm, t in s, vB, dirB, T_NAME; every other name is a parameter."),
    el("p", { class: "row" }, el("label", {}, "Where it acts", site), el("label", {}, "Component", component), el("label", {}, "Expression", expression)),
    answer, el("p", {}, put), command,
  ];
}
