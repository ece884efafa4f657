// What-if as bars: residual of the chosen effects next to that of each fit.

import { el, plain } from "./dom.js";

// `draw(rms, chosen)` follows what is switched: the indices of the changes that are on.
export function residualBars({ model, changes }) {
  const widest = Math.max(model.rms_um, ...changes.map(({ rms_um: um }) => um));
  const bar = (name, id) => {
    const fill = el("span", { class: "fill" });
    const figure = el("span", { class: "figure" });
    const line = el("li", id ? { id } : {}, el("span", { class: "name" }, name), el("span", { class: "residual-bar", "aria-hidden": "true" }, fill), figure);
    const show = (um) => {
      fill.style.width = `${Number.isFinite(um) ? Math.min(100, (100 * um) / widest) : 0}%`;
      figure.textContent = Number.isFinite(um) ? `${plain(um)} µm` : "—";
    };
    return { line, show };
  };
  const now = bar("Chosen now", "now");
  const fits = [["The model", model.rms_um], ...changes.map(({ title, without, rms_um: um }) => [`${without ? "without" : "with"} ${title}`, um])].map(([name, um]) => {
    const one = bar(name);
    one.show(um);
    return one.line;
  });
  return {
    place: el("ul", { class: "steps residual-bars", "aria-label": "Residual of each set of effects, rms" }, now.line, fits),
    draw(rms, chosen) {
      now.show(rms);
      // The model, or the change that is the only one: the fit that was made of what is chosen.
      const at = chosen.length === 0 ? 0 : chosen.length === 1 ? chosen[0] + 1 : -1;
      fits.forEach((line, i) => (i === at ? line.setAttribute("aria-current", "true") : line.removeAttribute("aria-current")));
    },
  };
}
