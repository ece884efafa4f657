// One run as one story: what is wrong, how large, how sure, what to do; where the model fails; which effect; what was added.

import * as calls from "./calls.js";
import { el, fold, list, markup, notice, paragraphs, remember, remembered } from "./dom.js";

// Parts of the report under their questions.
const DETAILS = [
  ["sweeps", "Residual over single axes"],
  ["polars", "Residual around the turning axis"],
  ["positions", "Measured and predicted places"],
  ["parameters", "Location errors and other parameters"],
  ["timing", "Time quality"],
];

export async function make(page) {
  if (!page.run) {
    return [el("h1", {}, "No recording yet"), el("p", {}, "A recording appears here when its cycle ends."), measureLink()];
  }
  const known = page.known === page.run;
  if (!known) notice(`Analysing ${page.run} …`);
  let story;
  try {
    story = await calls.story(page.run);
  } finally {
    if (!known) notice("");
  }
  page.known = page.run;
  return parts(page, story);
}

const measureLink = () => el("p", {}, el("a", { href: "#measure", class: "button" }, "What is measured now"));

function parts(page, story) {
  const section = (id) => story.sections.find((part) => part.id === id)?.html;
  const who = el("input", { id: "who", autocomplete: "name", maxlength: "60", value: remembered() });
  const shown = (id) => section(id) && markup(section(id));
  const detail = ([id, title]) => section(id) && fold(title, () => under(markup(section(id))));
  return [
    el("h1", {}, story.headline),
    el("div", { class: "lead" }, paragraphs(story.wrong)),
    el("dl", { class: "facts" }, story.facts.map(fact)),
    el("div", { class: "two" },
      el("section", {}, el("h2", {}, "How sure this is"), list(story.sure)),
      el("section", {}, el("h2", {}, "What to do"), el("ol", { class: "todo" }, story.to_do.map((text) => el("li", {}, text))))),
    shown("added"),
    el("section", { id: "where" }, shown("places"), detail(["maps", "Residual over the rotary axes"]), shown("spectrum")),
    el("section", { id: "which" }, el("h2", {}, "Which effect, and why"),
      story.candidates.length || story.removable.length ? el("p", { class: "row" }, el("label", {}, "Your name, kept with what you add or remove", who)) : null,
      candidates(page, story, who)),
    el("section", {}, el("h2", {}, "The model: what was added"), ladder(page, story, who), section("ladder") ? under(markup(section("ladder"))) : null),
    shown("missing"),
    unseen(story),
    ...DETAILS.map(detail).filter(Boolean),
    fold("By a recipe of the literature", () => methods(page.run)),
    el("p", {}, el("a", { class: "button", href: calls.reportAddress(page.run), target: "_blank" }, "Everything on one page")),
    filing(page.run),
  ];
}

const LANGUAGES = [["en", "English"], ["de", "Deutsch"], ["ja", "日本語"]];

// The same as `trunnion report RUN`: a page next to the recording, and a PDF where the computer of the program has a browser.
function filing(run) {
  const by = el("input", { id: "operator", autocomplete: "name", maxlength: "60", value: remembered() });
  const language = el("select", { id: "language" }, LANGUAGES.map(([code, name]) => el("option", { value: code, lang: code }, name)));
  const button = el("button", { type: "button", id: "file" }, "File the report");
  const said = el("div", { id: "filed", role: "status" });
  const say = (text, ...links) => said.replaceChildren(...(links.length ? [el("p", { class: "row" }, links)] : []), el("p", {}, text));
  const link = (text, href, name) => el("a", { class: "button", href, ...(name ? { download: name } : { target: "_blank" }) }, text);
  button.addEventListener("click", async () => {
    button.disabled = true;
    say("Writing the report …");
    try {
      const { html } = await calls.file(run, by.value.trim(), language.value);
      remember(by.value.trim() || remembered());
      const page = [link("Open the report", calls.filedAddress(run)), link("Download the page", calls.filedAddress(run), `${run}.report.html`)];
      say(`${html} is written. Making the PDF …`, ...page);
      try {
        const { pdf, pdf_lacks: lacks } = await calls.print(run);
        say(`Kept as ${html} and ${pdf}.${lacks ? ` The PDF is not complete: ${lacks}.` : ""}`, ...page, link("Download the PDF", calls.printedAddress(run), `${run}.report.pdf`));
      } catch (failure) {
        say(`Kept as ${html}. There is no PDF: ${failure.message}.`, ...page);
      }
    } catch (failure) {
      say(`The report is not written: ${failure.message}.`);
    }
    button.disabled = false;
  });
  return el("section", { id: "filing" }, el("h2", {}, "File a report"),
    el("p", {}, "A report to be filed: verdict, what to do, pass or fail on the first page; machine, recording and every table behind it."),
    el("p", { class: "row" }, el("label", {}, "Who measured", by), el("label", {}, "Language", language), button), said);
}

const fact = ({ name, value, remark }) => el("div", {}, el("dt", {}, name), el("dd", {}, value, el("small", {}, remark)));

function candidates(page, story, who) {
  if (story.withheld) return el("p", { class: "warn" }, story.withheld);
  if (!story.candidates.length) return el("p", {}, "No effect is proposed: the answer above says why.");
  const cards = story.candidates.map((candidate, index) => card(page, candidate, who, index === 0));
  const isFound = (index) => index === 0 || story.candidates[index].found;
  const found = cards.filter((_, index) => isFound(index));
  const others = cards.filter((_, index) => !isFound(index));
  return [
    ...found,
    others.length ? el("details", {}, el("summary", {}, el("h3", {}, `Other candidates (${others.length})`)), ...others) : null,
  ].filter(Boolean);
}

function card(page, candidate, who, first) {
  const { effect, title, falls, evidence, about, rivals, separate_by: separates, sizes } = candidate;
  const add = el("button", { class: first ? "main" : "", type: "button", "data-add": effect, "aria-label": `Add to the model: ${title}` }, "Add to the model");
  add.addEventListener("click", () => change(page, add, who, () => calls.add(page.run, effect, who.value.trim()), effect, "added"));
  const size = ([name, value, u]) => el("tr", {}, el("td", {}, name), el("td", { class: "n" }, value), el("td", { class: "n" }, u));
  const more = [
    ...about.map(([label, text]) => el("p", {}, el("b", {}, `${label}: `), text)),
    sizes.length
      ? el("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": `Size of ${effect}` },
          el("table", {}, el("thead", {}, el("tr", {}, ["parameter", "value", "standard uncertainty u"].map((head, k) => el("th", { scope: "col", class: k > 0 && "n" }, head)))),
            el("tbody", {}, sizes.map(size))))
      : null,
  ];
  return el("article", { class: "card" },
    el("h3", {}, title),
    el("p", { class: "large-number" }, `${falls[0]} → ${falls[1]} `, el("small", { class: "soft" }, "residual, rms")),
    el("p", {}, evidence),
    rivals.length ? el("p", {}, el("b", {}, "Confounded with: "), rivals.join("; ")) : null,
    separates ? el("p", {}, el("b", {}, "What separates them: "), separates) : null,
    el("p", { class: "row" }, add, el("a", { class: "button", href: calls.trialAddress(page.run, effect), target: "_blank" }, "Before and after, on maps")),
    el("details", { open: first }, el("summary", {}, "Why, and how large"), ...more.filter(Boolean)));
}

const NOTHING_ADDED = "Nothing yet: the model has location errors and ball setting alone.";

function ladder(page, story, who) {
  const rows = story.ladder.rows.filter((row) => row.ladder);
  if (!rows.length && !story.ladder.removed.length) return el("p", {}, NOTHING_ADDED);
  const step = ({ effect, ladder: row }) => {
    const remove = el("button", { type: "button", "data-remove": effect }, `Remove ${effect}`);
    remove.addEventListener("click", () => change(page, remove, who, () => calls.remove(page.run, effect, who.value.trim()), effect, "removed"));
    const by = [row.by, row.date].filter(Boolean).join(", ");
    return el("li", {}, el("span", { class: "name" }, el("b", {}, effect), by ? ` added by ${by}` : ""),
      story.removable.includes(effect) ? remove : null);
  };
  const gone = ({ effect, by, date }) => el("li", { class: "soft" }, `${effect} removed${by ? ` by ${by}` : ""}, ${date}`);
  const removed = story.ladder.removed.map(gone);
  return [rows.length ? null : el("p", {}, NOTHING_ADDED), el("ul", { class: "steps" }, rows.map(step), removed)].filter(Boolean);
}

// The same run by named methods, each a page of its own; what a method lacks is said.
function methods(run) {
  const place = el("div", {}, el("p", { class: "soft" }, "Asking each method …"));
  const line = ({ name, title, source, problem }) => el("li", {},
    problem ? el("b", {}, name) : el("a", { class: "button", href: calls.methodAddress(run, name), target: "_blank" }, name),
    ` ${title}. `, el("small", { class: "soft" }, problem ? `Not from this run: ${problem}` : source));
  calls.methods(run).then(
    (list) => place.replaceChildren(el("ul", {}, list.methods.map(line))),
    (failure) => place.replaceChildren(el("p", { class: "warn" }, failure.message)));
  return [place];
}

// A part of the report under our heading: its own says the same, and several divide it.
function under(part) {
  const heads = [...part.querySelectorAll("h2")];
  heads.forEach((head) => (heads.length > 1 ? head.replaceWith(el("h3", {}, head.textContent)) : head.remove()));
  return part;
}

function unseen(story) {
  const parts = [
    ["These readings leave confounded", story.not_observable],
    ["This cycle cannot show", story.not_visible],
    ["Out of reach of these runs", story.out_of_reach],
  ].filter(([, texts]) => texts.length);
  if (!parts.length) return el("p", {}, "Every parameter of the model is observable.");
  return fold("What is not observable",
    () => parts.flatMap(([title, texts]) => [el("h3", {}, title), list(texts, { class: texts.length > 6 ? "long" : "" })]));
}

async function change(page, button, who, call, effect, done) {
  if (who && !who.value.trim()) {
    notice("Who does it? Write your name first.", true);
    who.focus();
    return;
  }
  if (who) remember(who.value.trim());
  document.querySelectorAll("#view button").forEach((other) => (other.disabled = true));
  notice(`${button.textContent}: fitting again …`);
  page.changing = effect;
  try {
    const story = await call();
    const place = document.getElementById("view");
    place.replaceChildren(...parts(page, story));
    const rms = story.facts[0];
    notice(`${effect} is ${done}. ${rms.name} ${rms.value} ${rms.remark}.`);
    // Whoever works by keyboard goes on where the model changed.
    (place.querySelector(`[data-remove="${CSS.escape(effect)}"]`) ?? place.querySelector("h1")).focus();
    window.scrollTo(0, 0);
  } catch (failure) {
    page.changing = null;
    notice(failure.message, true);
    document.querySelectorAll("#view button").forEach((other) => (other.disabled = false));
  }
}
