// Which view is shown, of which run; what the service publishes goes to the view that wants it.

import * as calls from "./calls.js";
import { el, notice } from "./dom.js";
import * as result from "./result.js";
import * as measure from "./measure.js";
import * as whatIf from "./what-if.js";
import * as history from "./history.js";
import * as setUp from "./set-up.js";
import { login } from "./login.js";

const views = { "set-up": setUp, result, measure, "what-if": whatIf, history };
const page = { status: null, runs: [], run: null, topics: {}, show, choose, reload };
const place = document.getElementById("view");
const select = document.getElementById("run");
const news = document.getElementById("news");
let shown = 0;

async function reload() {
  page.runs = (await calls.runs()).runs;
  if (!page.runs.some((line) => line.name === page.run)) page.run = newest();
  const options = page.runs.map((line) => el("option", { value: line.name, selected: line.name === page.run }, titleOf(line.name)));
  select.replaceChildren(...options);
  select.disabled = page.runs.length < 2;
  select.parentElement.hidden = !page.runs.length;
}

// Of a name that ends with a moment the moment stands first: a phone shows how a line begins, and runs of one day differ at the end.
function titleOf(name) {
  const [, cycle, date, time, more] = /^(.+)-(\d{8})T(\d{6})Z(-\d+)?$/.exec(name) ?? [];
  if (!cycle) return name;
  const day = date.replace(/(....)(..)(..)/, "$1-$2-$3");
  return `${day} ${time.replace(/(..)(..)(..)/, "$1:$2:$3")} UTC ${cycle}${more ?? ""}`;
}

// The run that was measured last; not that which was analysed last, as those that wait are analysed newest first.
function newest() {
  const readable = page.runs.findLast((line) => !line.trouble && !line.removed);
  return (readable ?? page.runs.at(-1))?.name ?? null;
}

// The run that the service analysed last.
function analysed() {
  const name = page.topics.result?.run?.replace(/\.mcap$/, "");
  return page.runs.some((line) => line.name === name) ? name : null;
}

function choose(name) {
  page.run = name;
  select.value = name;
  news.hidden = true;
  show();
}

// Views of one run or of all: who reads them has made choices there.
const READ = ["result", "what-if", "history"];

// Another run was analysed: who reads one stays there and is offered the other.
async function follow(view) {
  const read = READ.includes(view) ? page.run : null;
  await reload();
  const name = analysed();
  if (!name) return;
  if (!read || (read === name && view === "result")) {
    choose(name);
    return;
  }
  const button = el("button", { type: "button" }, "Show it");
  button.addEventListener("click", () => {
    choose(name);
    location.hash = "#result";
  });
  news.replaceChildren(`Run ${name} was analysed. `, button);
  news.hidden = false;
}

async function show() {
  const wanted = location.hash.slice(1);
  const name = wanted in views ? wanted : page.runs.length ? "result" : "measure";
  document.querySelectorAll("nav a").forEach((link) => {
    if (link.dataset.view === name) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  });
  const number = ++shown;
  place.setAttribute("aria-busy", "true");
  try {
    // The first run may have come since the list was made.
    if (!page.run) await reload();
    const parts = await views[name].make(page);
    if (number !== shown) return;
    place.replaceChildren(...parts);
    views[name].shown?.(page);
  } catch (failure) {
    // Samples that were removed left their report.
    const left = failure.status === 410 ? [el("p", {}, el("a", { class: "button", href: calls.reportAddress(page.run), target: "_blank" }, "Its report"))] : [];
    if (number === shown) place.replaceChildren(el("h1", {}, "This cannot be shown"), el("p", {}, failure.message), ...left);
  }
  if (number === shown) place.setAttribute("aria-busy", "false");
}

function listen() {
  const events = new EventSource("/api/live");
  for (const topic of ["status", "cycle", "quality", "ready", "set-up", "result", "alarms", "live", "model", "storage", "removed"]) {
    events.addEventListener(topic, (event) => take(topic, JSON.parse(event.data)));
  }
  events.onerror = () => notice("The program does not answer; the page tries again.", true);
  events.onopen = () => notice("");
}

// Values of the newest run outside their limits are seen on every view.
function markHistory() {
  const names = (page.topics.alarms?.alarms ?? []).map((alarm) => alarm.words || alarm.name);
  const link = document.querySelector('[data-view="history"]');
  link.textContent = names.length ? "History ⚠" : "History";
  const words = `Outside the limits of the runs before: ${names.join("; ")}`;
  names.length ? link.setAttribute("aria-label", `History. ${words}`) : link.removeAttribute("aria-label");
  link.title = names.length ? words : "";
}

async function take(topic, value) {
  const before = page.topics[topic];
  page.topics[topic] = value;
  if (topic === "alarms") markHistory();
  const view = document.querySelector("nav a[aria-current]")?.dataset.view;
  views[view]?.changed?.(page, topic);
  // What is sent on connecting is what the page was made with.
  const isNew = JSON.stringify(before) !== JSON.stringify(value);
  if (topic === "result" && isNew) await follow(view);
  if (topic === "model" && value.effect === page.changing) {
    page.changing = null;
  } else if (topic === "model" && isNew && value.run === page.run) {
    notice(`${value.effect} was ${value.state} in another window.`);
    if (view !== "measure") show();
  }
}

select.addEventListener("change", () => choose(select.value));
window.addEventListener("hashchange", async () => {
  await show();
  place.focus({ preventScroll: true });
  window.scrollTo(0, 0);
});

try {
  page.status = await calls.status();
} catch (failure) {
  if (failure.status !== 401) throw failure;
  await login(place);
  page.status = await calls.status();
}
document.querySelector('[data-view="set-up"]').hidden = page.status.serves !== "service";
page.topics = page.status.topics;
markHistory();
document.getElementById("name").textContent = page.status.name;
document.getElementById("program").textContent = page.status.program;
document.title = `Trunnion: ${page.status.name}`;
await reload();
await show();
listen();
