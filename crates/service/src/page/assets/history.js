// The runs of the folder: what changed, residual, verdict and values over time with their control limits.

import * as calls from "./calls.js";
import { colour, el, fold, notice, paragraphs, plain, remember, remembered } from "./dom.js";

export async function make(page) {
  await page.reload();
  const runs = page.runs;
  if (!runs.length) return [el("h1", {}, "History"), el("p", {}, "There is no recording yet.")];
  const open = runs.filter((run) => !run.found && !run.trouble && !run.removed);
  const analyse = el("button", { type: "button", class: "main" }, `Analyse ${open.length} more`);
  analyse.addEventListener("click", () => analyseAll(page, open, analyse));
  const history = await calls.history();
  const watched = history.watched.filter(({ name }) => name !== "rms");
  const alarms = new Set(history.runs.at(-1)?.alarms);
  const option = ({ name }) => el("option", { value: name, selected: alarms.has(name) }, alarms.has(name) ? `${name}: outside its limits` : name);
  const chosen = el("select", { id: "parameter" }, watched.map(option));
  const charts = el("div", {});
  const redraw = () => charts.replaceChildren(...draw(history, chosen.value));
  chosen.addEventListener("change", redraw);
  redraw();
  return [
    el("h1", {}, runs.length === 1 ? "One run" : `${runs.length} runs`),
    open.length ? el("p", {}, analyse) : null,
    changes(history),
    corrections(page, history),
    table(page, runs),
    watched.length ? el("p", { class: "row" }, el("label", {}, "Value over time", chosen)) : null,
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
    const gone = run.removed ? el("small", { class: "soft" }, ` samples removed ${run.removed}`) : null;
    // What a person looks for stands first: a small screen shows the first columns.
    return el("tr", {}, el("td", {}, pick), el("td", {}, verdict, gone),
      el("td", { class: "n" }, found ? `${plain(found.rms_um)} µm` : "—"), el("td", {}, run.began || "—"), el("td", {}, run.machine || "—"),
      el("td", {}, found ? found.effects.slice(2).join(", ") || "none" : "—"));
  };
  const head = ["run", "verdict", "residual, rms", "began", "machine", "effects added"].map((text) => el("th", { scope: "col" }, text));
  return el("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "Runs" },
    el("table", {}, el("thead", {}, el("tr", {}, head)), el("tbody", {}, runs.toReversed().map(row))));
}

function changes({ change, runs, notes }) {
  if (!change) return null;
  const { run, alarms } = runs.at(-1);
  const alarm = alarms.length ? el("p", { class: "warn" }, `${run}: outside its control limits: ${alarms.join(", ")}`) : null;
  return el("section", { id: "changes" }, el("h2", {}, `What changed from ${change.from} to ${change.to}`), alarm, paragraphs([...change.words, ...notes]));
}

// What each correction did, and the place to say that one was entered.
function corrections(page, { machine, around_corrections: around }) {
  if (!machine) return null;
  const who = el("input", { id: "corrected-by", autocomplete: "name", maxlength: "60", value: remembered() });
  const what = el("input", { id: "corrected-what", maxlength: "60" });
  const enter = el("button", { type: "button" }, "It was entered now");
  enter.addEventListener("click", async () => {
    enter.disabled = true;
    try {
      await calls.corrected(who.value.trim(), what.value.trim());
      remember(who.value.trim());
      await page.show();
      notice("The correction is kept. Control limits begin again with the next run.");
    } catch (failure) {
      notice(failure.message, true);
      enter.disabled = false;
    }
  });
  const form = fold("A correction was entered into the control", () => [
    el("p", {}, `Limits of ${machine} begin again after it, and the runs before and after it are compared.`),
    el("p", { class: "row" }, el("label", {}, "Your name", who), el("label", {}, "What was entered", what), enter)]);
  const shown = around.map(({ words }) => el("div", { class: "card" }, paragraphs(words)));
  return el("section", { id: "corrections" }, shown.length ? el("h2", {}, "Before and after a correction") : null, ...shown, form);
}

function draw({ runs, watched, corrections: entered }, parameter) {
  if (runs.length < 2) return [el("p", { class: "soft" }, "A chart over time needs two analysed runs.")];
  const times = runs.map((run) => run.began_s);
  const dated = times.every((time) => time != null) && times.every((time, i) => i === 0 || time > times[i - 1]);
  const x = dated ? times : runs.map((_, i) => i + 1);
  const of = (name) => {
    const one = watched.find((value) => value.name === name);
    if (!one) return null;
    const along = (value) => runs.map((_, i) => one.points.filter(({ run }) => run === i).map(value)[0] ?? null);
    const unit = one.unit.replace("urad", "µrad").replace("um", "µm");
    const title = name === "rms" ? `Residual, rms, ${unit}, with control limits` : `${name}, ${unit}, with control limits`;
    // The first limits are wide; the scale is that of the values and the last limits.
    const shown = [...one.points.map(({ value }) => value), ...(one.points.at(-1)?.limits ?? []).slice(1)];
    const margin = 0.05 * (Math.max(...shown) - Math.min(...shown)) || 1;
    // A residual is no less than nothing.
    const least = name === "rms" ? 0 : -Infinity;
    const range = [Math.max(least, Math.min(...shown) - margin), Math.max(...shown) + margin];
    const marks = dated ? entered.map(({ at_s: at }) => at) : [];
    const shownChart = chart(title, x, dated, range, marks, [
      { label: name === "rms" ? "residual, rms" : name, values: along(({ value }) => value), stroke: "--blue" },
      { label: "lower limit", values: along(({ limits }) => limits && Math.max(least, limits[1])), stroke: "--grey", points: false },
      { label: "upper limit", values: along(({ limits }) => limits?.[2] ?? null), stroke: "--grey", points: false },
    ]);
    if (one.next) shownChart.append(el("p", {}, `Expected of the next run, if the machine stays as it is: ${plain(one.next[0])} ${unit}, 95 % interval ${plain(Math.max(least, one.next[1]))} to ${plain(one.next[2])} ${unit}.`));
    return shownChart;
  };
  const note = `Limits are set by the runs before${entered.length ? ", since the last correction (dashed upright line)" : ""}: at most one false alarm in 365 runs over all values together.`;
  return [of("rms"), parameter ? of(parameter) : null, el("p", { class: "soft" }, note)].filter(Boolean);
}

function chart(title, x, dated, range, marks, series) {
  const place = el("div", { class: "chart", role: "img", "aria-label": `${title}: ${series[0].values.map((value) => (value == null ? "—" : plain(value))).join(", ")}` });
  const numbers = dated ? {} : { incrs: [1, 2, 5, 10, 20, 50, 100, 200] };
  const axis = { stroke: colour("--ink"), grid: { stroke: colour("--line"), width: 1 } };
  requestAnimationFrame(() => {
    const width = Math.max(240, Math.min(900, place.clientWidth || 600));
    const one = ({ label, stroke, points = true }) => ({ label, stroke: colour(stroke), width: 2, dash: points ? [] : [6, 4], points: { show: points, size: 7 }, spanGaps: true });
    new uPlot({ width, height: 240, scales: { x: { time: dated }, y: { range } }, axes: [{ ...axis, ...numbers }, axis], legend: { live: false }, hooks: { draw: [(plot) => mark(plot, marks)] }, series: [{ label: dated ? "began" : "run" }, ...series.map(one)] },
      [x, ...series.map(({ values }) => values)], place);
  });
  return el("section", {}, el("h2", {}, title), place);
}

// A dashed line where a correction was entered.
function mark({ ctx, bbox, valToPos }, moments) {
  ctx.save();
  ctx.strokeStyle = colour("--orange");
  ctx.lineWidth = 2;
  ctx.setLineDash([4, 4]);
  for (const moment of moments) {
    const at = valToPos(moment, "x", true);
    if (at < bbox.left || at > bbox.left + bbox.width) continue;
    ctx.beginPath();
    ctx.moveTo(at, bbox.top);
    ctx.lineTo(at, bbox.top + bbox.height);
    ctx.stroke();
  }
  ctx.restore();
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
