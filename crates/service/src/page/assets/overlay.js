// Two curves of the residual laid over each other: setup against setup, forward against back.

import { over, printed } from "./chart.js";
import { colour, el, minus, plain } from "./dom.js";
import { degrees, nearest, stations } from "./heat-map.js";

// Places of the selection that are written out.
const SAID = 6;
const STROKES = ["--blue", "--orange", "--ink", "--grey"];

// `draw(takes, excluded)` follows what is chosen, `mark(poses)` the selection; `select` is called with the poses of a place of the curves.
export function overlay(state, select) {
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
  const apart = el("span", { id: "apart" });
  const places = el("span", { id: "places" });
  const said = el("p", { class: "soft", "aria-live": "polite" }, apart, places);
  const inputs = [kind, along, component];
  let [plot, takes, excluded, marked] = [null, null, new Set(), []];

  // Whether a pose is one of a curve of the kind that is chosen.
  const isDrawn = (i) => takes[i] && !excluded.has(i) && kinds[Number(kind.value)].of(i) != null;
  const stationOf = (axis, i) => nearest(axis.at, linear.points[i].position[axis.i]);

  // Mean of each curve at each place of the axis; null where nothing was read.
  function curves() {
    const { names, of } = kinds[Number(kind.value)];
    const axis = at[Number(along.value)];
    const name = components[Number(component.value)];
    const sums = names.map(() => axis.at.map(() => [0, 0]));
    linear.points.forEach((point, i) => {
      const [curve, k] = [of(i), linear.setups[point.setup].components.indexOf(name)];
      if (!isDrawn(i) || k < 0) return;
      const cell = sums[curve][stationOf(axis, i)];
      cell[0] += residual[firstRow[i] + k];
      cell[1] += 1;
    });
    return { names, axis, name, values: sums.map((curve) => curve.map(([sum, count]) => (count ? sum / count : null))) };
  }

  const apartOf = ({ axis, values }) => Math.max(...axis.at.map((_, k) => {
    const here = values.map((curve) => curve[k]).filter((value) => value != null);
    return here.length > 1 ? Math.max(...here) - Math.min(...here) : 0;
  }), 0);

  // It opens where the curves are furthest apart: what a person looks for.
  function chooseLargest() {
    const all = kinds.flatMap((_, a) => at.flatMap((__, b) => components.map((___, c) => [a, b, c])));
    const set = (choice) => inputs.forEach((input, k) => (input.value = choice[k]));
    const sizes = all.map((choice) => {
      set(choice);
      return apartOf(curves());
    });
    set(all[sizes.indexOf(Math.max(...sizes))]);
  }

  // Places of the selection on the axis.
  function selected() {
    const axis = at[Number(along.value)];
    return [...new Set(marked.filter(isDrawn).map((i) => axis.at[stationOf(axis, i)]))];
  }

  // An upright line at each place of the selection.
  function markers({ ctx, bbox, valToPos }) {
    ctx.save();
    ctx.strokeStyle = colour("--ink");
    ctx.lineWidth = 2;
    for (const place of selected()) {
      const x = valToPos(place, "x", true);
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
    }
    ctx.restore();
  }

  function sayPlaces() {
    const found = selected();
    const more = found.length > SAID ? ` and ${found.length - SAID} more places` : "";
    places.textContent = found.length ? ` The upright line is the selection: ${at[Number(along.value)].name} ${found.slice(0, SAID).map(degrees).join(", ")}${more}.` : "";
  }

  function draw() {
    const shown = curves();
    const { names, axis, name, values } = shown;
    // Curves and axes have other names for every choice.
    plot?.destroy();
    plot = null;
    apart.textContent = `${names.join(", ")}: they are ${plain(apartOf(shown))} µm apart at most, in component ${name} over ${axis.name}; means over everything else that is chosen.`;
    sayPlaces();
    if (!place.clientWidth) return;
    const one = (label, k) => ({ label, stroke: colour(STROKES[k % STROKES.length]), width: 2, points: { show: true, size: 7 } });
    plot = new uPlot({
      width: Math.max(240, Math.min(1100, place.clientWidth)), height: 240, scales: { x: { time: false } },
      axes: over(`${axis.name}, °`, "residual, µm"), hooks: { draw: [markers] }, series: [{ label: `${axis.name}, °`, value: (_, v) => (v == null ? "—" : minus(String(v))) }, ...names.map(one)],
    }, [axis.at, ...values], place);
    printed(plot);
    plot.over.addEventListener("click", () => {
      const k = plot.cursor.idx;
      if (k != null) select(linear.points.map((_, i) => i).filter((i) => isDrawn(i) && stationOf(axis, i) === k));
    });
  }
  inputs.forEach((input) => input.addEventListener("change", draw));
  return {
    section: el("section", { id: "overlay" }, el("h2", {}, "Two curves laid over each other"),
      el("p", { class: "row" }, el("label", {}, "Curves", kind), el("label", {}, "Along", along), el("label", {}, "Component", component)), place, said),
    draw(takesNow, excludedNow) {
      const isFirst = !takes;
      [takes, excluded] = [takesNow, excludedNow];
      if (isFirst) chooseLargest();
      if (place.isConnected) draw();
      else requestAnimationFrame(draw);
    },
    mark(poses) {
      marked = poses;
      sayPlaces();
      plot?.redraw(false, false);
    },
  };
}
