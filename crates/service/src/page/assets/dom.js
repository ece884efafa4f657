// Elements without markup from strings: texts stay texts.

export function el(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value === true) made.setAttribute(name, "");
    else if (value !== false && value != null) made.setAttribute(name, value);
  }
  made.append(...children.flat().filter((child) => child != null));
  return made;
}

// Figures as crates/results/src/number.rs writes them; a test compares both.

// Two digits at least, three where they are left of the second decimal; a power of ten where that is too long.
export function plain(value) {
  if (!Number.isFinite(value)) return "—";
  const decimals = decimalsOf(value);
  return decimals === null ? minus(power(value)) : decimal(value, decimals);
}

// The same with no digit that a standard uncertainty does not justify.
export function justified(value, u) {
  if (!(Number.isFinite(value) && Number.isFinite(u) && u > 0)) return plain(value);
  const most = decimalsOfU(u);
  const own = decimalsOf(value);
  if (own === null && Math.abs(value) >= 1) return plain(value);
  return decimal(value, Math.min(own ?? most, most));
}

// So many decimals.
export const decimal = (value, decimals) => (Number.isFinite(value) ? minus(fixed(value, decimals)) : "—");

// A value and its standard uncertainty with two digits of that.
export function withU(value, u) {
  if (!(Number.isFinite(value) && Number.isFinite(u) && u > 0)) return [plain(value), "—"];
  const decimals = decimalsOfU(u);
  return [decimal(value, decimals), decimal(u, decimals)];
}

// A true minus sign, and none before what is written as zero.
export const minus = (text) => (/[1-9]/.test(text) ? text.replaceAll("-", "−") : text.replace("-", ""));

// Decimals of `plain`; none for what is written with a power of ten.
function decimalsOf(value) {
  const size = Math.abs(value);
  if (size >= 1e6 || (size > 0 && size < 1e-3)) return null;
  return size >= 99.95 ? 0 : size >= 9.995 ? 1 : size >= 0.0995 || size === 0 ? 2 : size >= 0.00995 ? 3 : 4;
}

const decimalsOfU = (u) => Math.min(6, Math.max(0, 1 - Math.floor(Math.log10(u / 0.995))));

// Digits beyond which a number that is no tie differs from one.
const DIGITS = 40;

// So many decimals; what lies in the middle goes to the even digit, which `toFixed` does not.
const fixed = (value, decimals) => even(value.toFixed(decimals), value.toFixed(DIGITS), DIGITS - decimals);

// Two digits and a power of ten.
function power(value) {
  const [digits, exponent] = value.toExponential(1).split("e");
  const [exact, below] = value.toExponential(DIGITS).split("e");
  // A mantissa that is rounded up to ten has another exponent, and is no tie to an even digit.
  const shown = exponent === below ? even(digits, exact, DIGITS - 1) : digits;
  return `${shown}e${Number(exponent)}`;
}

function even(up, exact, cut) {
  const low = exact.slice(0, -cut).replace(/\.$/, "");
  return /^50*$/.test(exact.slice(-cut)) && Number(low.at(-1)) % 2 === 0 ? low : up;
}

export const paragraphs = (texts) => texts.map((text) => el("p", {}, text));

export function list(texts, attributes = {}) {
  return el("ul", attributes, texts.map((text) => el("li", {}, text)));
}

// A closed part with a heading; its content is made when it is opened first.
export function fold(title, make, open = false) {
  const body = el("div");
  const part = el("details", { open }, el("summary", {}, el("h2", {}, title)), body);
  const fill = () => part.open && !body.firstChild && body.append(...[make()].flat());
  part.addEventListener("toggle", fill);
  fill();
  return part;
}

// Markup of the report: made by the program, its texts are escaped there; scripts in it would not run.
export function markup(html) {
  const parsed = new DOMParser().parseFromString(html, "text/html");
  return el("div", {}, ...parsed.body.childNodes);
}

export function notice(text, bad = false) {
  const line = document.getElementById("notice");
  line.textContent = text;
  line.className = bad ? "bad" : "";
}

// The value of a colour of the style sheet.
export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// The name that a person gave last.
export function remembered() {
  try {
    return localStorage.getItem("name") ?? "";
  } catch {
    return "";
  }
}

export function remember(name) {
  try {
    localStorage.setItem("name", name);
  } catch {
    // A private window forgets.
  }
}
