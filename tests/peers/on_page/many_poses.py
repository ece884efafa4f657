"""A run of 10 000 poses: it paints, a click is followed at once; the figures are printed, or written with `PAGE_FIGURES`."""

import json
import os
import pathlib
import time

from checks import check, trunnion
from on_page.tab import DATA, Served, Tab, rms_um

FIGURES = os.environ.get("PAGE_FIGURES")


def many_poses(browser, folder):
    """A run of 10 000 poses at rest, every one another: what the service computes for it, what the browser takes, what a person waits for."""
    truth = folder / "sagging.toml"
    sag = {"across": 1.0, "along": 0.2, "upright": 0.45, "across_upright": 0.15, "windup_rad_per_mm": 0.002, "windup_phase_rad": 0.3}
    shape = ", ".join(f"{name} = {size}" for name, size in sag.items())
    machine = (DATA.parents[1] / "config/truths/table-bc.toml").read_text()
    truth.write_text(f'{machine}\n[[hidden]]\nid = "gravity-sag:B"\namplitude = 0.01\nshape = {{ {shape} }}\n')
    cycle = folder / "poses-10000.toml"
    grid = lambda axis, low, high, step: f'[[grid]]\naxis = "{axis}"\nfrom_deg = {low}\nto_deg = {high}\nstep_deg = {step}\n\n'
    static = (DATA.parents[1] / "config/cycles/r-test-static.toml").read_text()
    head, settle = static[:static.index('[[setup]]\nname = "high"')], static[static.index("[settle]"):]
    head = head.replace('passes = ["+", "-"]', 'passes = ["+"]').replace("r-test-static", "poses-10000")
    cycle.write_text(head + grid("B", -89.1, 89.1, 1.8) + grid("C", 0, 356.4, 3.6) + settle)
    run = folder / "poses-10000.mcap"
    trunnion("simulate", truth, "--cycle", cycle, "-o", run)
    children = lambda: sum(os.times()[2:4])
    before = children()
    diagnosis = json.loads(trunnion("diagnose", run, "--json"))
    diagnosed_s = children() - before
    check("the sag of 10 000 poses is found", diagnosis["candidates"][0]["effect"] == "gravity-sag:B", f"{diagnosed_s:.1f} s of a processor")
    size_mb, nodes = {}, {}
    with Served(run) as address:
        tab = Tab(browser, address)
        # The body of a large answer is gone when the browser has parsed it.
        tab.page.on("response", lambda got: size_mb.__setitem__(got.url.rsplit("/", 1)[1], int(got.headers.get("content-length", 0)) / 1e6))

        def painted(view):
            began = time.monotonic()
            tab.view(view)
            took_s = time.monotonic() - began
            nodes[view] = tab.page.evaluate("document.querySelectorAll('*').length")
            tab.picture(f"poses-10000-{view}")
            return took_s

        result_s = painted("result")
        check("the headline names the effect", "gravity-sag:B" in tab.text("h1"), tab.text("h1"))
        rms = rms_um(tab.text(".facts dd"))
        tab.page.get_by_text("Measured and predicted places").click()
        tab.until("/Of [0-9]+ places around C, one in [0-9]+ is drawn/.test(document.querySelector('main').innerText)")
        check("places left out of a picture are said", True)
        tab.picture("poses-10000-places")
        what_if_s = painted("what-if")
        shown = lambda: float(tab.page.locator("#rms").get_attribute("data-um"))
        check("10 000 poses paint", abs(shown() - rms) < 0.006, f"{size_mb['linear']:.1f} MB, fits and page {what_if_s:.1f} s")
        took_ms = tab.page.evaluate("""() => {
            const box = document.querySelector('input[value="gravity-sag:B"]');
            const began = performance.now();
            box.click();
            return performance.now() - began;
        }""")
        check("a click is followed at once", took_ms < 500, f"{took_ms:.0f} ms")
        check("by the map too", shown() < 0.5 * rms, shown())
        tab.page.get_by_text("Every pose").click()
        tab.until("document.querySelector('[aria-label=\"Residual of poses\"]')?.checkVisibility()")
        rows = tab.page.locator('[aria-label="Residual of poses"] tbody tr').count()
        check("the table comes in pages, and says so", rows == 50 and "1 to 50 of 10000 poses" in tab.text("main"), f"{rows} rows")
        tab.picture("poses-10000-table")
        again_s = painted("result")
        tab.close()
    figures([
        ("diagnosis, seconds of a processor", f"{diagnosed_s:.1f}"),
        ("Result: what the browser takes, MB", f"{size_mb['poses-10000']:.2f}"),
        ("Result: elements of the page", nodes["result"]),
        ("Result: from opening the view to its first paint, diagnosis included, s", f"{result_s:.1f}"),
        ("the same once more, s", f"{again_s:.2f}"),
        ("What if: what the browser takes, MB", f"{size_mb['linear']:.2f}"),
        ("What if: elements of the page", nodes["what-if"]),
        ("What if: from opening the view to its first paint, fits of every effect included, s", f"{what_if_s:.1f}"),
        ("What if: an effect switched: maps, chart, arrows, table follow, ms", f"{took_ms:.0f}"),
    ])


def figures(rows):
    """Printed; with PAGE_FIGURES=docs/measured/page.md written there too."""
    table = "".join(f"| {what} | {figure} |\n" for what, figure in rows)
    print(table, flush=True)
    if FIGURES:
        begin, end = "<!-- begin: 10 000 poses -->\n", "<!-- end: 10 000 poses -->"
        page = pathlib.Path(FIGURES).read_text()
        before, rest = page.split(begin)
        pathlib.Path(FIGURES).write_text(f"{before}{begin}| | |\n|---|---:|\n{table}{end}{rest.split(end)[1]}")
