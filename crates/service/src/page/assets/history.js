// The runs of the folder: what changed, residual, verdict and values over time with their control limits.

import * as calls from "./calls.js";
import { over, printed } from "./chart.js";
import { colour, decimal, el, fold, justified, notice, paragraphs, plain, remember, remembered, withU } from "./dom.js";

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
  const option = (one) => el("option", { value: one.name, selected: alarms.has(one.name) }, alarms.has(one.name) ? `Outside its limits: ${titleOf(one)}` : titleOf(one));
  const chosen = el("select", { id: "parameter" }, watched.map(option));
  const charts = el("div", {});
  const redraw = () => charts.replaceChildren(...draw(history, chosen.value));
  chosen.addEventListener("change", redraw);
  redraw();
  return [
    el("h1", {}, runs.length === 1 ? "One run" : `${runs.length} runs`),
    open.length ? el("p", {}, analyse) : null,
    changes(page, history),
    corrections(page, history),
    table(page, runs),
    watched.length && history.runs.length > 1 ? el("p", { class: "row" }, el("label", {}, "Value over time", chosen)) : null,
    charts,
    nextDay(),
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
    // Answers of older versions know the first only.
    const named = found?.named.length ? found.named.join("; ") : found?.candidate;
    const verdict = found ? [VERDICTS[found.verdict] ?? found.verdict, named].filter(Boolean).join(": ") : run.trouble || "not analysed yet";
    const gone = run.removed ? el("small", { class: "soft" }, ` samples removed ${run.removed}`) : null;
    // What a person looks for stands first: a small screen shows the first columns.
    return el("tr", {}, el("td", {}, pick), el("td", {}, verdict, gone),
      el("td", { class: "n" }, found ? `${plain(found.rms_um)} µm` : "—"), el("td", { class: "n" }, found?.temperature_degc == null ? "—" : `${decimal(found.temperature_degc, 1)} °C`), el("td", {}, run.began || "—"), el("td", {}, run.machine || "—"),
      el("td", {}, found ? found.effects.slice(2).join(", ") || "none" : "—"));
  };
  const figures = ["residual, rms", "temperature"];
  const head = ["run", "verdict", ...figures, "began", "machine", "effects added"].map((text) => el("th", { scope: "col", class: figures.includes(text) && "n" }, text));
  return el("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "Runs" },
    el("table", {}, el("thead", {}, el("tr", {}, head)), el("tbody", {}, runs.toReversed().map(row))));
}

function changes(page, { change, runs, notes, watched }) {
  if (!change) return null;
  const { run, alarms } = runs.at(-1);
  const alarm = alarms.length ? el("p", { class: "warn" }, `${run}: outside its control limits: ${alarms.map((name) => titleOf(watched.find((one) => one.name === name))).join("; ")}`) : null;
  const shown = (...parts) => el("section", { id: "changes" }, el("h2", {}, `What changed from ${change.from} to ${change.to}`), alarm, ...parts, paragraphs(notes));
  const words = el("div", { role: "status" }, paragraphs(change.words));
  // The same as the command reports takes fits of both runs: which effect, and whether the earlier values predict the later run.
  const hasSamples = (name) => page.runs.some((one) => one.name === name && !one.removed);
  if (![change.from, change.to].every(hasSamples)) return shown(words);
  const asking = el("p", { class: "soft" }, "Which effect changed: fitting both runs …");
  const ask = calls.change();
  ask.then(({ words: said }) => words.replaceChildren(...paragraphs(said)), (failure) => words.append(el("p", { class: "soft" }, `Which effect changed is not known: ${failure.message}.`)));
  ask.finally(() => asking.remove()).catch(() => {});
  return shown(words, asking);
}

// What the day after these runs is expected to show; asked for by hand, as all runs are fitted together.
function nextDay() {
  const ask = el("button", { type: "button", id: "next-day" }, "Forecast the next day");
  const answer = el("div", { role: "status", id: "forecast" });
  ask.addEventListener("click", async () => {
    ask.disabled = true;
    notice("Fitting these runs together …");
    try {
      const forecast = await calls.nextDay();
      answer.replaceChildren(...paragraphs(forecast.words), ...(forecast.values.length ? [expected(forecast.values)] : []));
      notice("");
    } catch (failure) {
      notice(failure.message, true);
    }
    ask.disabled = false;
  });
  return el("section", {}, el("h2", {}, "The next day"), el("p", { class: "row" }, ask), answer);
}

function expected(values) {
  const row = (one) => {
    const shown = one.unit.replace("urad", "µrad").replace("um", "µm");
    const figures = withU(one.value, one.u).map((text) => el("td", { class: "n" }, `${text} ${shown}`));
    return el("tr", {}, el("td", {}, titleOf(one)), figures);
  };
  const head = ["value", "expected", "standard uncertainty u of one more day"].map((text, k) => el("th", { scope: "col", class: k > 0 && "n" }, text));
  return el("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "Expected values" },
    el("table", {}, el("thead", {}, el("tr", {}, head)), el("tbody", {}, values.map(row))));
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
  const order = dated ? "day, UTC" : orderOf(times);
  const of = (name) => {
    const one = watched.find((value) => value.name === name);
    if (!one) return null;
    const unit = one.unit.replace("urad", "µrad").replace("um", "µm");
    const limits = one.points.filter((point) => point.limits).map((point) => ({ run: point.run, ends: point.limits.slice(1) }));
    // A residual is no less than nothing.
    const range = scaleOf(one.points.map(({ value }) => value), limits.at(-1)?.ends ?? [], name === "rms" ? 0 : -Infinity);
    const marks = dated ? entered.map(({ at_s: at }) => at) : [];
    const values = runs.map((_, i) => one.points.find(({ run }) => run === i)?.value ?? null);
    const drawn = chart({ title: `${capital(titleOf(one))}, with control limits`, x, dated, order, range, unit, marks, label: name === "rms" ? "residual, rms" : name, values, limits });
    const digits = (ends) => ends.map((end) => justified(end, (ends[1] - ends[0]) / 2)).join(" to ");
    const wide = limits.filter(({ ends }) => ends[0] < range[0] || ends[1] > range[1]);
    const shown = wide.slice(0, SAID).map(({ run, ends }) => `${runs[run].run} ${digits(ends)} ${unit}`);
    if (wide.length > SAID) shown.push(`and ${wide.length - SAID} more`);
    if (wide.length) drawn.append(el("p", { class: "soft" }, `Limits that are wider than the picture (few runs were before): ${shown.join("; ")}.`));
    return drawn;
  };
  const note = `Limits are set by the runs before${entered.length ? ", since the last correction (dashed upright line)" : ""}: at most one false alarm in 365 runs over all values together.`;
  const degc = runs.map((run) => run.temperature_degc ?? null);
  const temperature = () => chart({
    title: "Temperature, mean of all channels", x, dated, order, range: scaleOf(degc.filter((one) => one != null), [], -Infinity), unit: "°C",
    marks: dated ? entered.map(({ at_s: at }) => at) : [], label: "temperature", values: degc, limits: [],
  });
  return [of("rms"), parameter ? of(parameter) : null, el("p", { class: "soft" }, note), degc.some((one) => one != null) ? temperature() : null].filter(Boolean);
}

// What the list of runs is in order of, where they are not all dated apart.
function orderOf(times) {
  const undated = times.filter((time) => time == null).length;
  if (!undated) return "run, in order of time";
  return undated === times.length ? "run, in order of names" : "run, those without a date first";
}

// Runs whose limits are written out.
const SAID = 4;

// `direction of axis B about X (EA0B)`.
const titleOf = ({ name, words }) => (words && words !== name ? `${words}${name === "rms" ? "" : ` (${name})`}` : name);

const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);

// A judgement, tuned on no data: values within less than this share of the height (8 px) are one flat line.
const FLAT = 1 / 30;

// Ends of the y axis: every value, and the limits of the last run where they leave the values a shape. The first limits are wide.
function scaleOf(values, last, least) {
  const spread = (of) => Math.max(...of) - Math.min(...of);
  const all = [...values, ...last];
  const shown = spread(values) > 0 && spread(values) < FLAT * spread(all) ? values : all;
  const [low, high] = [Math.min(...shown), Math.max(...shown)];
  const margin = 0.1 * (high - low) || 1;
  return [Math.max(least, low - margin), high + margin];
}

function chart({ title, x, dated, order, range, unit, marks, label, values, limits }) {
  const said = values.map((value) => (value == null ? "—" : plain(value))).join(", ");
  const place = el("div", { class: "chart", role: "img", "aria-label": `${title}, ${unit}: ${said}` });
  const along = dated ? days : { incrs: [1, 2, 5, 10, 20, 50, 100, 200] };
  requestAnimationFrame(() => {
    const width = Math.max(240, Math.min(900, place.clientWidth || 600));
    const stroke = colour("--blue");
    // Drawn by hand: a limit belongs to its run, and not to the time between two.
    const limit = (name) => ({ label: name, stroke: colour("--ink"), width: 2, dash: [6, 4], paths: () => null, points: { show: false } });
    const of = (k) => values.map((_, i) => limits.find(({ run }) => run === i)?.ends[k] ?? null);
    printed(new uPlot({
      // Room for the last day's name and the limits of its run.
      width, height: 260, padding: [12, 40, 0, 0], tzDate: (at) => uPlot.tzDate(new Date(at * 1000), "UTC"), scales: { x: { time: dated }, y: { range } }, axes: over(order, unit, along), legend: { live: false },
      hooks: { draw: [(plot) => mark(plot, marks), (plot) => bars(plot, x, limits, range)] },
      series: [{ label: dated ? "began" : "run" }, { label, stroke, width: 2, points: { show: true, size: 7, fill: stroke }, spanGaps: true }, ...(limits.length ? [limit("lower limit"), limit("upper limit")] : [])],
    }, [x, values, ...(limits.length ? [of(0), of(1)] : [])], place));
  });
  return el("section", {}, el("h2", {}, `${title}, ${unit}`), place);
}

// Days as the list of runs writes them; hours where all runs are of few days.
const HOUR = 3600;
const days = {
  incrs: [1, 3, 6, 12, 24, 48, 120, 240, 720, 2160, 8760].map((hours) => hours * HOUR),
  space: 100,
  values: (_, splits, __, ___, step) => splits.map((at) => {
    const text = new Date(at * 1000).toISOString();
    return step < 24 * HOUR ? `${text.slice(5, 10)} ${text.slice(11, 16)}` : text.slice(0, 10);
  }),
};

// A short dashed bar at each end of the limits of a run.
function bars({ ctx, valToPos }, x, limits, range) {
  const at = x.map((value) => valToPos(value, "x", true));
  const apart = Math.min(...at.slice(1).map((place, i) => place - at[i]));
  const scale = window.devicePixelRatio || 1;
  const half = Math.max(5 * scale, Math.min(30 * scale, 0.4 * apart));
  ctx.save();
  ctx.strokeStyle = colour("--ink");
  ctx.lineWidth = 2 * scale;
  ctx.setLineDash([6 * scale, 4 * scale]);
  for (const { run, ends } of limits) {
    for (const end of ends.filter((value) => value >= range[0] && value <= range[1])) {
      const y = valToPos(end, "y", true);
      ctx.beginPath();
      ctx.moveTo(at[run] - half, y);
      ctx.lineTo(at[run] + half, y);
      ctx.stroke();
    }
  }
  ctx.restore();
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
