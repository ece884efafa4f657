// Setting up at the machine, step by step: what is done, what comes next.

import * as calls from "./calls.js";
import { decimal, el, notice } from "./dom.js";
import { axisPlaces, deviceRows, probeBar } from "./live.js";

let parts = null;

export async function make(page) {
  parts = null;
  if (page.status.serves !== "service") {
    return [
      el("h1", {}, "Nothing is set up here"),
      el("p", {}, "Steps of setting up need the service at a machine: trunnion daemon --config FILE. The same as commands: trunnion calibrate-nest, trunnion watch --sign-test, trunnion watch."),
    ];
  }
  const step = (title, about, ...more) => {
    const state = el("span", { class: "state" });
    const body = el("div", {});
    return { state, body, card: el("li", { class: "card" }, el("h2", {}, title, " ", state), el("p", {}, about), body, ...more) };
  };
  const finish = button("Finish the calibration", calls.finishNest);
  const write = button("Write them into the configuration", calls.writeNest, "main");
  // One for each of the two steps that can be stopped; shown while its step is under way.
  const stop = { nest: button("Stop", calls.stopSetUp), sign: button("Stop", calls.stopSetUp) };
  const lines = el("pre", { class: "scroll", tabindex: "0", "aria-label": "The table nest of the configuration" });
  // Made once: what is made again with every reading closes under the hand.
  const byHand = el("details", {}, el("summary", {}, "The lines for the configuration, to enter by hand"), lines);
  parts = {
    stop,
    lines,
    byHand,
    next: el("p", { class: "todo", role: "status", id: "next-step" }),
    // Steps of the nest and jogs of the sign test are made by these.
    axes: el("p", { class: "places" }),
    finish,
    write,
    devices: step("1. Devices", "Every device is connected and sends."),
    nest: step("2. Directions of the probes", "Known steps of X, Y and Z with the rotary axes at rest show the direction of each probe. Once after the nest was mounted.",
      el("p", { class: "row" }, button("Begin the calibration", calls.beginNest, "main"), finish, write, stop.nest), byHand),
    sign: step("3. Sign test", "Jogs show whether each probe follows as the configuration says, or is turned or exchanged.",
      el("p", { class: "row" }, button("Begin the sign test", calls.beginSignTest, "main"), stop.sign)),
    zero: step("4. Ball at the centre", "Every probe in the middle half of its range: errors and settings stay within it."),
    measure: el("p", {}, el("a", { class: "button", href: "#measure" }, "5. Choose the cycle and measure")),
  };
  changed(page, "all");
  return [el("h1", {}, "Set up"), parts.next, el("h2", {}, "Axes"), parts.axes, el("ol", { class: "guide" }, [parts.devices, parts.nest, parts.sign, parts.zero].map(({ card }) => card)), parts.measure];
}

function button(text, call, kind = "") {
  const made = el("button", { type: "button", class: kind }, text);
  made.addEventListener("click", async () => {
    try {
      await call();
      notice("");
    } catch (failure) {
      notice(failure.message, true);
    }
  });
  return made;
}

export function changed(page, topic) {
  if (!parts || !["all", "live", "status", "set-up", "cycle"].includes(topic)) return;
  const { live, status, cycle } = page.topics;
  const setUp = page.topics["set-up"];
  const measuring = cycle?.state === "measuring";
  const devices = Object.values(status?.devices ?? {});
  const connected = devices.length > 0 && devices.every(({ state }) => state === "Streaming");
  show(parts.devices, connected, connected ? "done" : "not yet", el("ul", { class: "steps" }, deviceRows(live, status)));
  parts.axes.replaceChildren(...axisPlaces(live));
  parts.stop.nest.hidden = setUp?.step !== "nest";
  parts.stop.sign.hidden = setUp?.step !== "sign-test";
  showNest(setUp);
  const followed = setUp?.sign_test?.finding === "as-nest";
  show(parts.sign, followed, setUp?.step === "sign-test" ? "under way" : followed ? "done" : "not done here",
    el("p", {}, setUp?.step === "sign-test" ? `${setUp.dwells} dwells. ${setUp.last}` : ""),
    setUp?.sign_test ? el("p", { class: "lead" }, setUp.sign_test.say) : null);
  const probes = live?.probes ?? [];
  const centred = probes.length > 0 && probes.every(({ zone }) => zone === "centre");
  show(parts.zero, centred, centred ? "done" : "not yet", el("p", { class: "lead" }, live?.say ?? ""), el("div", { class: "two" }, probes.map(probeBar)));
  parts.next.textContent = nextStep({ measuring, connected, setUp, centred });
}

function showNest(setUp) {
  const underWay = setUp?.step === "nest";
  parts.finish.hidden = !underWay;
  const nest = setUp?.nest;
  parts.write.hidden = !nest || Boolean(setUp.written);
  const worst = nest ? Math.max(...nest.probes.map((probe) => probe.u_direction_mrad)) : null;
  show(parts.nest, Boolean(nest), underWay ? "under way" : nest ? "done" : "from the configuration",
    underWay ? el("p", {}, `${setUp.dwells} dwells. ${setUp.last}`) : null,
    setUp?.problem ? el("p", { class: "warn" }, setUp.problem) : null,
    nest ? el("p", {}, `Standard uncertainty of the directions: at most ${decimal(worst, 2)} mrad, from ${nest.steps} dwells.`) : null,
    setUp?.written ? el("p", { class: "lead" }, setUp.written) : null);
  parts.byHand.hidden = !nest;
  if (nest && parts.lines.textContent !== nest.lines) parts.lines.textContent = nest.lines;
}

function nextStep({ measuring, connected, setUp, centred }) {
  if (measuring) return "A cycle is being measured: wait for its end, or abort it.";
  if (setUp?.step) return setUp.to_do;
  if (!connected) return "Next: connect the devices; each says below what is wrong with it.";
  if (setUp?.nest) return setUp.to_do;
  if (setUp?.sign_test && setUp.sign_test.finding !== "as-nest") return setUp.to_do;
  if (!setUp?.sign_test) return "Next: the sign test. Calibrate the nest first where it was mounted again.";
  if (!centred) return "Next: bring the ball to the centre.";
  return "Ready: choose the cycle and measure.";
}

function show(step, good, word, ...content) {
  step.state.textContent = word;
  step.state.className = `state ${good ? "ok" : ""}`;
  step.body.replaceChildren(...content.filter(Boolean));
}
