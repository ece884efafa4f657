// The runs of the folder: residual, verdict and location errors over time.

import * as calls from "./calls.js";
import { colour, el, notice, plain } from "./dom.js";

export async function make(page) {
  await page.reload();
  const runs = page.runs;
  if (!runs.length) return [el("h1", {}, "History"), el("p", {}, "There is no recording yet.")];
  const open = runs.filter((run) => !run.found && !run.trouble);
  const analyse = el("button", { type: "button", class: "main" }, `Analyse ${open.length} more`);
  analyse.addEventListener("click", () => analyseAll(page, open, analyse));
  const chosen = el("select", { id: "parameter" }, names(runs).map((name) => el("option", {}, name)));
  const charts = el("div", {});
  const redraw = () => charts.replaceChildren(...draw(runs, chosen.value));
  chosen.addEventListener("change", redraw);
  redraw();
  return [
    el("h1", {}, runs.length === 1 ? "One run" : `${runs.length} runs`),
    open.length ? el("p", {}, analyse) : null,
    table(page, runs),
    names(runs).length ? el("p", { class: "row" }, el("label", {}, "Location error", chosen)) : null,
    charts,
  ].filter(Boolean);
}

const VERDICTS = {
  "missing-effect": "an effect is missing",
  "unnamed-structure": "something without a name is missing",
  "noise-floor": "nothing is missing",
  undecided: "undecided",
  "not-judged": "not judged",
};

function table(page, runs) {
  const row = (run) => {
    const pick = el("button", { type: "button" }, run.name);
    pick.addEventListener("click", () => {
      page.run = run.name;
      document.getElementById("run").value = run.name;
      location.hash = "#result";
    });
    const { found } = run;
    const verdict = found ? [VERDICTS[found.verdict] ?? found.verdict, found.candidate].filter(Boolean).join(": ") : run.trouble || "not analysed yet";
    return el("tr", {}, el("td", {}, pick), el("td", {}, run.began || "—"), el("td", {}, run.machine || "—"),
      el("td", { class: "n" }, found ? `${plain(found.rms_um)} µm` : "—"), el("td", {}, verdict),
      el("td", {}, found ? found.effects.slice(2).join(", ") || "none" : "—"));
  };
  const head = ["run", "began", "machine", "residual, rms", "verdict", "effects added"].map((text) => el("th", { scope: "col" }, text));
  return el("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "Runs" },
    el("table", {}, el("thead", {}, el("tr", {}, head)), el("tbody", {}, runs.toReversed().map(row))));
}

const names = (runs) => [...new Set(runs.flatMap((run) => run.found?.location_errors.map((error) => error.name) ?? []))];

function draw(runs, parameter) {
  const known = runs.filter((run) => run.found);
  if (known.length < 2) return [el("p", { class: "soft" }, "A chart over time needs two analysed runs.")];
  const times = known.map((run) => run.began_s);
  const dated = times.every((time) => time != null) && times.every((time, i) => i === 0 || time > times[i - 1]);
  const x = dated ? times : known.map((_, i) => i + 1);
  const error = (run) => run.found.location_errors.find((one) => one.name === parameter);
  const unit = known.map(error).find(Boolean)?.unit.replace("urad", "µrad").replace("um", "µm") ?? "";
  const value = known.map((run) => error(run)?.value ?? null);
  const limits = (sign) => known.map((run) => {
    const one = error(run);
    return one?.u == null ? null : one.value + sign * 2 * one.u;
  });
  return [
    chart("Residual, rms, µm", x, dated, [{ label: "residual, rms", values: known.map((run) => run.found.rms_um), stroke: "--blue" }]),
    parameter ? chart(`${parameter}, ${unit}, with 95 % interval`, x, dated, [
      { label: parameter, values: value, stroke: "--blue" },
      { label: "lower", values: limits(-1), stroke: "--grey" },
      { label: "upper", values: limits(1), stroke: "--grey" },
    ]) : null,
  ].filter(Boolean);
}

function chart(title, x, dated, series) {
  const place = el("div", { class: "chart", role: "img", "aria-label": `${title}: ${series[0].values.map((value) => (value == null ? "—" : plain(value))).join(", ")}` });
  const numbers = dated ? {} : { incrs: [1, 2, 5, 10, 20, 50, 100, 200] };
  const axis = { stroke: colour("--ink"), grid: { stroke: colour("--line"), width: 1 } };
  requestAnimationFrame(() => {
    const width = Math.max(240, Math.min(900, place.clientWidth || 600));
    const one = ({ label, stroke }) => ({ label, stroke: colour(stroke), width: 2, points: { show: true, size: 7 }, spanGaps: true });
    new uPlot({ width, height: 240, scales: { x: { time: dated } }, axes: [{ ...axis, ...numbers }, axis], legend: { live: false }, series: [{ label: dated ? "began" : "run" }, ...series.map(one)] },
      [x, ...series.map(({ values }) => values)], place);
  });
  return el("section", {}, el("h2", {}, title), place);
}

async function analyseAll(page, open, button) {
  button.disabled = true;
  for (const [index, run] of open.entries()) {
    notice(`Analysing ${run.name}, ${index + 1} of ${open.length} …`);
    try {
      await calls.story(run.name);
    } catch (failure) {
      notice(`${run.name}: ${failure.message}`, true);
    }
  }
  notice("");
  page.show();
}
