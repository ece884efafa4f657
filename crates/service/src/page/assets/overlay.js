// Two curves of the residual laid over each other: setup against setup, forward against back.

import { over, printed } from "./chart.js";
import { colour, el, minus, plain } from "./dom.js";
import { nearest, stations } from "./heat-map.js";

const STROKES = ["--blue", "--orange", "--ink", "--grey"];

// `draw(takes, excluded)` follows what is chosen.
export function overlay(state) {
  const { linear, rotary, firstRow, residual } = state;
  const at = rotary.map((axis) => ({ ...axis, at: stations(linear.points.map((point) => point.position[axis.i])) })).filter((axis) => axis.at.length > 1);
  const kinds = [
    { title: "setup against setup", names: linear.setups.map(({ name }) => `setup ${name}`), of: (i) => linear.points[i].setup },
    ...at.map(({ name, i: axis }) => ({ title: `${name} forward against back`, names: [`${name} forward`, `${name} back`], of: (i) => ({ 1: 0, "-1": 1 })[linear.points[i].direction[axis]] ?? null })),
  ].filter(({ names, of }) => names.length > 1 && names.every((_, k) => linear.points.some((__, i) => of(i) === k)));
  if (!kinds.length || !at.length) return null;
  const components = [...new Set(linear.setups.flatMap((setup) => setup.components))];
  const choice = (id, texts) => el("select", { id }, texts.map((text, k) => el("option", { value: k }, text)));
  const [kind, along, component] = [choice("against", kinds.map(({ title }) => title)), choice("along", at.map(({ name }) => name)), choice("of", components)];
  const place = el("div", { class: "chart" });
  const said = el("p", { class: "soft", id: "apart", "aria-live": "polite" });
  let [plot, takes, excluded] = [null, [], new Set()];

  // Mean of each curve at each place of the axis; null where nothing was read.
  function curves() {
    const { names, of } = kinds[Number(kind.value)];
    const axis = at[Number(along.value)];
    const name = components[Number(component.value)];
    const sums = names.map(() => axis.at.map(() => [0, 0]));
    linear.points.forEach((point, i) => {
      const [curve, k] = [of(i), linear.setups[point.setup].components.indexOf(name)];
      if (!takes[i] || excluded.has(i) || curve == null || k < 0) return;
      const cell = sums[curve][nearest(axis.at, point.position[axis.i])];
      cell[0] += residual[firstRow[i] + k];
      cell[1] += 1;
    });
    return { names, axis, name, values: sums.map((curve) => curve.map(([sum, count]) => (count ? sum / count : null))) };
  }

  function draw() {
    const { names, axis, name, values } = curves();
    // Curves and axes have other names for every choice.
    plot?.destroy();
    plot = null;
    const apart = Math.max(...axis.at.map((_, k) => {
      const here = values.map((curve) => curve[k]).filter((value) => value != null);
      return here.length > 1 ? Math.max(...here) - Math.min(...here) : 0;
    }), 0);
    said.textContent = `${names.join(", ")}: they are ${plain(apart)} µm apart at most, in component ${name} over ${axis.name}; means over everything else that is chosen.`;
    if (!place.clientWidth) return;
    const one = (label, k) => ({ label, stroke: colour(STROKES[k % STROKES.length]), width: 2, points: { show: true, size: 7 } });
    plot = new uPlot({
      width: Math.max(240, Math.min(1100, place.clientWidth)), height: 240, scales: { x: { time: false } },
      axes: over(`${axis.name}, °`, "residual, µm"), series: [{ label: `${axis.name}, °`, value: (_, v) => (v == null ? "—" : minus(String(v))) }, ...names.map(one)],
    }, [axis.at, ...values], place);
    printed(plot);
  }
  [kind, along, component].forEach((input) => input.addEventListener("change", draw));
  return {
    section: el("section", { id: "overlay" }, el("h2", {}, "Two curves laid over each other"),
      el("p", { class: "row" }, el("label", {}, "Curves", kind), el("label", {}, "Along", along), el("label", {}, "Component", component)), place, said),
    draw(takesNow, excludedNow) {
      [takes, excluded] = [takesNow, excludedNow];
      if (place.isConnected) draw();
      else requestAnimationFrame(draw);
    },
  };
}
