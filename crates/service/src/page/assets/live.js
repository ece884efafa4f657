// What is read at this moment: a probe in its range, an axis, a device with its remedy.

import { decimal, el } from "./dom.js";

export function probeBar({ name, value_mm: value, range_mm: range, zone, say }) {
  const known = value != null && range;
  const good = zone === "centre" || zone === "inside" || zone === "unknown";
  return el("div", { class: "card" },
    el("h3", {}, name, " ", el("span", { class: `state ${good ? "ok" : "bad"}` }, zone.replace("-", " "))),
    known ? gauge(name, value, range) : null,
    el("p", { class: "large-number" }, value == null ? "—" : `${decimal(value, 4)} mm`),
    say ? el("p", {}, say) : null);
}

// The measuring range with its centre zone, and where the probe is.
function gauge(name, value, [from, to]) {
  const mark = el("span", { class: "mark" });
  mark.style.left = `${100 * Math.max(0, Math.min(1, (value - from) / (to - from)))}%`;
  return el("div", { class: "gauge", role: "meter", "aria-label": `${name} in its range`, "aria-valuemin": from, "aria-valuemax": to, "aria-valuenow": value.toFixed(4) },
    el("span", { class: "zone" }), mark);
}

// Where the axes are, as the controller reports it.
export function axisPlaces(live) {
  const place = ({ name, value, unit }) => el("span", {}, el("b", {}, name), ` ${decimal(value, 3)}${unit === "deg" ? "°" : ` ${unit}`}`);
  const axes = live?.axes ?? [];
  return axes.length ? axes.map(place) : ["The controller reports no position yet."];
}

// What of the service itself is not as it should be, and its disk.
export function serviceRows(status, storage) {
  const parts = Object.entries(status?.health?.parts ?? {}).filter(([name, { state }]) => name !== "devices" && state !== "good");
  const row = (name, state, good, ...texts) => el("li", {}, el("span", { class: "name" }, el("b", {}, name)),
    el("span", { class: `state ${good ? "ok" : "bad"}` }, state), ...texts.filter(Boolean).map((text) => el("span", {}, text)));
  const rows = parts.map(([name, { state, why }]) => row(name, state, false, why));
  // The form before the first look, and after the last, has no numbers.
  if (storage?.state === undefined || storage.state === "offline") return rows;
  const { free_mb: free, runs, removed, not_removed: stays, lost_samples: lost } = storage;
  const count = (n) => (n === 1 ? "1 run" : `${n} runs`);
  rows.push(row("recordings", storage.state, storage.state === "good" && !stays,
    free == null ? null : `${decimal(free / 1000, 1)} GB free`,
    removed ? `the samples of ${removed} of ${count(runs + removed)} were removed to make room, the reports stay` : count(runs),
    lost ? `${lost} samples of the newest run could not be written` : null, stays));
  return rows;
}

export function deviceRows(live, status) {
  const remedies = Object.fromEntries((live?.devices ?? []).map((device) => [device.name, device]));
  const devices = Object.entries(status?.devices ?? {});
  const row = ([name, device]) => {
    const good = device.state === "Streaming";
    const remedy = remedies[name]?.remedy ?? (good ? null : device.last_end);
    return el("li", {},
      el("span", { class: "name" }, el("b", {}, name), device.identity ? ` ${device.identity}` : ""),
      el("span", { class: `state ${good ? "ok" : "bad"}` }, device.state),
      device.lost_messages ? el("span", {}, `${device.lost_messages} messages lost`) : null,
      remedy ? el("span", {}, remedy) : null);
  };
  return devices.length ? devices.map(row) : [el("li", {}, "No device yet.")];
}
