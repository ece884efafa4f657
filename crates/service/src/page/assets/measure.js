// What is measured now: probes in their range, devices with their remedy, the poses of the cycle filling a map.

import * as calls from "./calls.js";
import { el, notice } from "./dom.js";
import { axisPlaces, deviceRows, probeBar, serviceRows } from "./live.js";
import { poseMap } from "./pose-map.js";

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
    prompt: el("p", { class: "todo", role: "status", id: "prompt" }),
    progress: el("progress", { max: "1", value: "0", "aria-label": "Poses read" }),
    left: el("p", {}),
    gaps: el("ul", { "aria-label": "Gaps" }),
    probes: el("div", { class: "two" }),
    devices: el("ul", { class: "steps" }),
    service: el("ul", { class: "steps", id: "service" }),
    axes: el("p", { class: "places" }),
    map: null, mapOf: null,
    maps: el("section", {}),
    controls: controls(page),
  };
  parts.values = el("section", {}, el("h2", {}, "Probes"), parts.probes, el("h2", {}, "Axes"), parts.axes);
  changed(page, "all");
  return [
    parts.headline, parts.prompt, parts.controls.form, parts.progress, parts.left, parts.gaps, parts.say,
    parts.maps, parts.values,
    el("h2", {}, "Devices"), parts.devices,
    ...(status.serves === "service" ? [el("h2", {}, "The service"), parts.service] : []),
  ];
}

export function changed(page, topic) {
  if (!parts) return;
  const { cycle, status, live, ready } = page.topics;
  if (topic === "all" || topic === "cycle" || topic === "status") {
    showMap(page);
    showCycle(cycle);
    parts.controls.show(cycle, status);
  }
  if (topic === "all" || topic === "storage" || topic === "status") parts.service.replaceChildren(...serviceRows(status, page.topics.storage));
  if (topic === "all" || topic === "live" || topic === "status") {
    showProbes(live);
    parts.devices.replaceChildren(...deviceRows(live, status));
    parts.gaps.replaceChildren(...(live?.cycle?.newest_gaps ?? []).map((gap) => el("li", {}, gap)));
  }
  showPrompt(page, cycle, ready);
}

// Which cycle is next, begin and abort; the answer comes with the topics.
function controls(page) {
  const { cycles, operates } = page.status;
  const name = ({ name, program }) => el("option", { value: name }, program ? `${name} (program ${program})` : name);
  const select = el("select", { id: "choose" }, el("option", { value: "" }, "as the program says"), ...cycles.map(name));
  const begin = el("button", { type: "button", class: "main", id: "begin" }, "Begin now");
  const abort = el("button", { type: "button", id: "abort" }, "Abort the cycle");
  const ask = async (call, done) => {
    try {
      await call();
      notice(done);
    } catch (failure) {
      notice(failure.message, true);
    }
  };
  select.addEventListener("change", () => ask(() => calls.choose(select.value), select.value ? `${select.value} is next.` : "The program says which cycle is next."));
  begin.addEventListener("click", () => ask(() => calls.begin(select.value), "The cycle begins."));
  // Twice, as a glove touches what it does not mean.
  let sure = null;
  const calm = () => {
    clearTimeout(sure);
    sure = null;
    abort.textContent = "Abort the cycle";
  };
  abort.addEventListener("click", () => {
    if (sure) {
      calm();
      ask(calls.abort, "The cycle is ended; what was read is kept.");
    } else {
      abort.textContent = "Press again to abort";
      sure = setTimeout(calm, 5000);
    }
  });
  const waiting = el("div", { class: "row" }, el("label", {}, "Next cycle", select), begin);
  const form = el("section", { "aria-label": "The cycle" }, operates ? waiting : null, el("p", {}, abort));
  const show = (cycle, status) => {
    const measuring = cycle?.state === "measuring";
    waiting.hidden = measuring;
    abort.hidden = !measuring;
    if (document.activeElement !== select) select.value = status?.chosen ?? "";
  };
  return { form, show };
}

// What a person does next.
function showPrompt(page, cycle, ready) {
  const known = cycleOf(page);
  const texts = [];
  if (cycle?.state === "measuring") {
    const poses = known?.grid?.poses ?? [];
    const done = cycle.done ?? 0;
    const [before, next] = [poses[done - 1]?.setup, poses[done]?.setup];
    if (next != null && next !== before && known.mounting[next]) texts.push(`${known.mounting[next]} Then let the program go on.`);
  } else if (page.status.operates) {
    if (ready && !ready.ready) texts.push(...ready.why.map((why) => `Not ready: ${why}.`));
    if (known?.mounting.length) texts.push(known.mounting[0]);
    const waits = cycle?.waits_for ?? page.waits;
    texts.push(waits ? `Then start the program (the service waits for ${waits}), or press Begin now.` : "Then start the program, or press Begin now.");
  }
  page.waits = cycle?.waits_for ?? page.waits;
  parts.prompt.hidden = !texts.length;
  parts.prompt.replaceChildren(...texts.flatMap((text, i) => (i ? [el("br"), text] : [text])));
}

// The cycle that runs, else the chosen one, else that of every program.
function cycleOf(page) {
  const { cycle, status } = page.topics;
  const wanted = [cycle?.state === "ready" ? null : cycle?.cycle, status?.chosen].filter(Boolean);
  const order = cycle?.state === "measuring" ? wanted : wanted.reverse();
  const { cycles } = page.status;
  return order.map((name) => cycles.find((known) => known.name === name)).find(Boolean) ?? cycles.find(({ program }) => !program) ?? cycles[0];
}

function showMap(page) {
  const known = cycleOf(page);
  if (parts.mapOf === known?.name) return;
  parts.mapOf = known?.name;
  parts.map = known?.grid ? poseMap(known.grid) : null;
  parts.asOf = el("p", { class: "soft", id: "as-of" });
  parts.maps.replaceChildren(...(known ? [el("h2", {}, `Poses of ${known.name}`), parts.asOf, parts.map?.figure ?? el("p", { class: "soft" }, "On the fly, or not over two rotary axes: there is no map of poses.")] : []));
}

// Why a cycle ended, as the service names it.
const ENDED = {
  Complete: "every pose was read", ControllerEnded: "the program of the machine ended", NoMotion: "no axis moved for too long", Stopped: "aborted",
};

function showCycle(cycle) {
  const state = cycle?.state;
  const words = {
    measuring: "Measuring", analysing: "The cycle is over and is being analysed", done: "The cycle is done",
    failed: "The cycle failed", refused: "No cycle belongs to this program",
  };
  const total = cycle?.total ?? 0;
  const done = state === "measuring" ? (cycle.done ?? 0) : 0;
  const over = state === "done" || state === "analysing";
  const whole = over && cycle.missing === 0 && cycle.unsettled === 0;
  const parted = state === "done" && cycle.missing > 0;
  parts.headline.textContent = parted ? "The cycle is over, a part of it is missing" : words[state] ?? "Waiting for the cycle";
  if (total) parts.progress.max = total;
  if (over) parts.progress.value = cycle.missing && cycle.read != null ? (parts.progress.max * cycle.read) / (cycle.read + cycle.unsettled + cycle.missing) : parts.progress.max;
  else parts.progress.value = done;
  fillMap(cycle, { whole, stays: parts.mapOf === cycle?.cycle && (over || state === "failed") });
  const left = cycle?.seconds_left;
  const texts = [];
  if (state === "measuring" && total) texts.push(`${done} of ${total} poses`);
  if (state === "measuring" && left != null) texts.push(`about ${Math.ceil(left)} s left`);
  if (over) texts.push(cycle.run, ENDED[cycle.ended] ?? cycle.ended);
  if (over && cycle.read != null) texts.push(`${cycle.read} read, ${cycle.unsettled} unsettled, ${cycle.missing} missing, ${cycle.gaps} gaps`);
  if (cycle?.why) texts.push(cycle.why);
  parts.left.textContent = texts.filter(Boolean).join("; ");
}

// What was read stays on the map until the next cycle begins, and whose it is stands above it.
function fillMap(cycle, { whole, stays }) {
  const [done, total] = [cycle?.done ?? 0, cycle?.total ?? 0];
  const until = cycle?.ended === "Stopped" ? "the cycle was aborted" : cycle?.state === "failed" ? "the cycle failed" : "the cycle ended";
  const read = cycle?.read == null ? "" : `, ${cycle.read} of them with a reading`;
  parts.asOf.textContent = stays && !whole && done ? `As of run ${cycle.run}: ${done} poses until ${until}${read}.` : "";
  parts.asOf.hidden = !parts.asOf.textContent;
  if (whole && stays) parts.map?.fill(Infinity);
  else if (stays) parts.map?.fill(done, null);
  else if (cycle?.state === "measuring" && total === parts.map?.poses) parts.map?.fill(done);
  else parts.map?.fill(0);
}

function showProbes(live) {
  parts.values.hidden = !live;
  parts.say.textContent = live?.say ?? "";
  const probes = live?.probes ?? [];
  if (!probes.length) {
    parts.probes.replaceChildren(el("p", { class: "soft" }, "No live values yet."));
  } else {
    parts.probes.replaceChildren(...probes.map(probeBar));
  }
  parts.axes.replaceChildren(...axisPlaces(live));
}
