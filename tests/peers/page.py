#!/usr/bin/env python3
"""The page in headless Chromium over the real program: `page.py TRUNNION`. Every check prints a line; the first that fails ends it.

Nothing is compared by pixels. `PAGE_SHOTS=FOLDER` keeps a picture of every view, to be looked at.
"""

import json
import os
import pathlib
import subprocess
import tempfile
import time

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import sync_playwright

from checks import TRUNNION, check, trunnion

DATA = pathlib.Path(__file__).resolve().parents[1] / "data"
SHOTS = os.environ.get("PAGE_SHOTS")
FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
         "--disable-background-networking", "--disable-component-update", "--disable-sync"]
VIEWS = ["result", "what-if", "history", "measure"]
# Unoptimised code on a busy computer: no promise of speed, an end of the wait.
LIMIT_MS = 90_000


class Served:
    """`trunnion open` until the end of the block."""

    def __init__(self, *runs):
        arguments = [TRUNNION, "open", *map(str, runs), "--listen", "127.0.0.1:0"]
        self.process = subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True)
        line = self.process.stdout.readline()
        check("the address is printed", "http://127.0.0.1:" in line, line.strip())
        self.address = line.split()[4]

    def __enter__(self):
        return self.address

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()


class Tab:
    """A page whose errors fail the test."""

    def __init__(self, browser, address, width=1280, height=800, scheme="light"):
        self.context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme)
        self.page = self.context.new_page()
        self.page.set_default_timeout(LIMIT_MS)
        self.errors = []
        self.page.on("console", lambda said: said.type == "error" and self.errors.append(said.text))
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.address = address

    def view(self, name):
        self.page.goto(f"{self.address}/#{name}")
        self.ready()

    def until(self, holds):
        """Playwright's own wait evaluates strings later, which the page's content policy refuses, as it should."""
        end = time.monotonic() + LIMIT_MS / 1000
        while not self.page.evaluate(holds):
            if time.monotonic() > end:
                check(f"within {LIMIT_MS // 1000} s: {holds}", False)
            self.page.wait_for_timeout(50)

    def ready(self):
        self.until("document.getElementById('view')?.getAttribute('aria-busy') === 'false'")

    def text(self, selector):
        return self.page.locator(selector).first.inner_text()

    def picture(self, name):
        if SHOTS:
            self.page.screenshot(path=f"{SHOTS}/{name}.png", full_page=True)

    def close(self):
        check("no error on the console", not self.errors, self.errors)
        self.context.close()


def rms_um(text):
    return float(text.split()[0])


def story_of_one_run(browser, folder):
    run, model = folder / "gravity.mcap", folder / "gravity.model.toml"
    trunnion("import", DATA / "points-gravity/points.csv", "--setup", DATA / "points-gravity/setup.toml", "-o", run)
    diagnosis = json.loads(trunnion("diagnose", run, "--json"))
    with Served(run) as address:
        tab, other = Tab(browser, address), Tab(browser, address, 820, 1180)
        tab.view("result")
        other.view("result")
        check("the headline names the engine's candidate", diagnosis["candidates"][0]["effect"] in tab.text("h1"), tab.text("h1"))
        before = rms_um(tab.text(".facts dd"))
        check("the residual is the engine's", abs(before - diagnosis["residual"]["rms_um"]) < 0.006, before)

        # By mouse, without a name first.
        tab.page.click('[data-add="gravity-sag:B"]')
        check("nobody adds without a name", "Who adds it?" in tab.text("#notice"), tab.text("#notice"))
        tab.page.fill("#who", "Ada")
        tab.page.click('[data-add="gravity-sag:B"]')
        tab.page.wait_for_selector('[data-remove="gravity-sag:B"]')
        after = rms_um(tab.text(".facts dd"))
        ladder = json.loads(trunnion("ladder", "--model", model, "--json"))["rows"][-1]["ladder"]
        check("the rms falls", after < before, (before, after))
        check("it equals trunnion ladder", abs(after - ladder["error_after_um"]) < 0.006, ladder["error_after_um"])
        check("the name is kept", ladder["by"] == "Ada" and "Ada" in tab.text(".steps"), tab.text(".steps li"))
        other.page.wait_for_selector('[data-remove="gravity-sag:B"]')
        check("the other browser shows it", "another window" in other.text("#notice"), other.text("#notice"))

        what_if(tab, after, before)

        # By keyboard alone: from the top of the page to the button, and Enter.
        tab.view("result")
        tab.page.reload()
        tab.page.wait_for_selector('[data-remove="gravity-sag:B"]')
        for presses in range(1, 100):
            tab.page.keyboard.press("Tab")
            if tab.page.evaluate("document.activeElement.dataset.remove") == "gravity-sag:B":
                break
        check("Tab reaches Remove", presses < 60, f"after {presses}")
        tab.page.keyboard.press("Enter")
        tab.page.wait_for_selector('[data-add="gravity-sag:B"]')
        check("Enter removes it", abs(rms_um(tab.text(".facts dd")) - before) < 0.006)
        check("the model file holds it no more", "gravity-sag" not in model.read_text())
        tab.close()
        other.close()


def what_if(tab, after, before):
    tab.view("what-if")
    tab.page.wait_for_selector("#rms")
    shown = lambda: float(tab.page.locator("#rms").get_attribute("data-um"))
    check("what-if begins at the fit", abs(shown() - after) < 0.006, shown())
    tab.page.uncheck('input[value="gravity-sag:B"]')
    check("without the effect it is the fit without it", abs(shown() - before) < 0.006, shown())
    check("and says so", f"{before:.2f} µm" in tab.text("#rms + p"), tab.text("#rms + p"))
    tab.page.check('input[value="gravity-sag:B"]')
    check("and back", abs(shown() - after) < 0.006, shown())
    tab.page.uncheck('input[value="low"]')
    check("a setup can be left out", "chosen setups" in tab.text("#rms + p"))
    tab.page.get_by_text("Try an expression").click()
    tab.page.fill("#expression", "k*sin(B_deg)")
    tab.until("document.body.innerText.includes('B_deg')")
    tab.page.fill("#expression", "k*cos(3*B)")
    tab.until("document.body.innerText.includes('--expression \"k*cos(3*B)\"')")
    check("an expression is checked as it is typed", True)


def every_width(browser, folder):
    for name in ["nothing-hidden", "unnamed"]:
        points = DATA / f"points-{name}"
        trunnion("import", points / "points.csv", "--setup", points / "setup.toml", "-o", folder / f"{name}.mcap")
    with Served(folder) as address:
        for width, height, scheme in [(1280, 800, "light"), (820, 1180, "dark"), (390, 844, "light")]:
            tab = Tab(browser, address, width, height, scheme)
            for view in VIEWS:
                tab.view(view)
                wide = tab.page.evaluate("document.documentElement.scrollWidth - innerWidth")
                check(f"{view} at {width} does not scroll sideways", wide <= 0, wide)
                small = tab.page.evaluate("""() => [...document.querySelectorAll('button, select, summary, nav a, .button, .choice, input:not([type=checkbox])')]
                    .filter((one) => one.offsetParent && one.getBoundingClientRect().height < 43.5).map((one) => one.outerHTML)""")
                check(f"{view} at {width}: targets are 44 px high", not small, small[:2])
                found = Axe().run(tab.page).response["violations"]
                grave = [(one["id"], one["nodes"][0]["html"][:120]) for one in found if one["impact"] in ("serious", "critical")]
                check(f"{view} at {width}, {scheme}: axe finds nothing serious", not grave, grave)
                tab.picture(f"{view}-{width}-{scheme}")
            tab.close()


def history(browser, folder):
    runs = folder / "history"
    runs.mkdir()
    truth = DATA.parents[1] / "config/truths/table-bc.toml"
    leaning = folder / "leaning.toml"
    leaning.write_text(truth.read_text().replace("EA0B_urad = 25.0", "EA0B_urad = 75.0"))
    for number in range(1, 6):
        trunnion("simulate", truth if number < 5 else leaning, "--run", number, "-o", runs / f"day-{number}.mcap")
    engine = json.loads(trunnion("history", "--folder", runs, "--json"))
    with Served(runs) as address:
        tab = Tab(browser, address)
        tab.view("history")
        tab.page.get_by_text("Analyse 5 more").click()
        tab.page.wait_for_selector("#changes")
        check("the change is the engine's", engine["change"]["words"][0] in tab.text("#changes"), engine["change"]["words"][0])
        check("the alarm is there", "outside its control limits: EA0B" in tab.text("#changes"), engine["runs"][-1]["alarms"])
        check("its chart is shown first", "EA0B" in tab.text("#parameter option[selected]"))
        tab.picture("history-limits")
        tab.close()


def many_poses(browser, folder):
    """What-if with every pose of a run thirty times: 10 080 poses. Result and history show means, however many poses there are."""
    times = 30

    def tiled(route):
        linear = route.fetch().json()
        linear["points"] *= times
        linear["residual_um"] *= times
        for column in linear["columns"]:
            column["values"] *= times
        route.fulfill(json=linear)

    with Served(folder / "gravity.mcap") as address:
        tab = Tab(browser, address)
        tab.view("result")
        rms = rms_um(tab.text(".facts dd"))
        tab.page.route("**/linear", tiled)
        began = time.monotonic()
        tab.view("what-if")
        painted = time.monotonic() - began
        shown = lambda: float(tab.page.locator("#rms").get_attribute("data-um"))
        check("10 080 poses paint", abs(shown() - rms) < 0.006, f"fits and page {painted:.1f} s")
        took_ms = tab.page.evaluate("""() => {
            const box = document.querySelector('input[value="gravity-sag:B"]');
            const began = performance.now();
            box.click();
            return performance.now() - began;
        }""")
        check("a click is followed at once", took_ms < 500, f"{took_ms:.0f} ms")
        check("by the map too", shown() < 0.5 * rms, shown())
        tab.close()


with sync_playwright() as playwright, tempfile.TemporaryDirectory() as temporary:
    chromium = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=FLAGS)
    folder = pathlib.Path(temporary)
    story_of_one_run(chromium, folder)
    every_width(chromium, folder)
    history(chromium, folder)
    many_poses(chromium, folder)
    chromium.close()
