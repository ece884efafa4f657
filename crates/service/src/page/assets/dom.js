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

// Two digits at least, three where they are left of the second decimal, as the program writes its figures.
export function plain(value) {
  const size = Math.abs(value);
  const decimals = size >= 99.95 ? 0 : size >= 9.995 ? 1 : size >= 0.0995 || size === 0 ? 2 : size >= 0.00995 ? 3 : 4;
  return minus(value.toFixed(decimals));
}

// The same with no digit that a standard uncertainty does not justify.
export function justified(value, u) {
  if (!(u > 0)) return plain(value);
  const decimals = Math.min(6, Math.max(0, 1 - Math.floor(Math.log10(u))));
  const most = plain(value).split(".")[1]?.length ?? 0;
  return minus(value.toFixed(Math.min(decimals, most)));
}

// A value and its standard uncertainty with two digits of that.
export function withU(value, u) {
  if (!(u > 0)) return [plain(value), "—"];
  const decimals = Math.min(6, Math.max(0, 1 - Math.floor(Math.log10(u))));
  return [minus(value.toFixed(decimals)), u.toFixed(decimals)];
}

export const minus = (text) => text.replace("-", "−");

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
  const part = el("div", {}, ...parsed.body.childNodes);
  // Tables that scroll sideways are reached by keyboard.
  part.querySelectorAll(".scroll").forEach((scroll) => {
    scroll.tabIndex = 0;
    scroll.setAttribute("role", "region");
    scroll.setAttribute("aria-label", scroll.querySelector("caption")?.textContent || "Table");
  });
  return part;
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
