"""A machine that changed: its history says so, and the service raises an alarm on every view."""

import json
import pathlib
import re
import time

from checks import check, trunnion
from on_page.tab import DATA, LIMIT_MS, Floor, Served, Tab


def five_days(runs):
    """Runs of a machine whose axis B leans since the last."""
    truth = DATA.parents[1] / "config/truths/table-bc.toml"
    leaning = runs / "leaning.toml"
    leaning.write_text(truth.read_text().replace("EA0B_urad = 25.0", "EA0B_urad = 75.0"))
    for number in range(1, 6):
        trunnion("simulate", truth if number < 5 else leaning, "--run", number, "-o", runs / f"day-{number}.mcap")


def alarmed(browser, folder):
    """The service over recordings of a machine that changed: its alarm is seen on every view, with words, and on a phone."""
    with Floor(folder, recorded=five_days) as floor:
        tab, phone = Tab(browser, floor.address), Tab(browser, floor.address, 390, 844, "dark")
        tab.view("measure")
        phone.view("measure")
        for one in (tab, phone):
            one.until("document.querySelector('[data-view=history]').textContent === 'History ⚠'")
        said = tab.page.get_attribute("[data-view=history]", "aria-label")
        check("the alarm is said in words", "direction of axis B about X" in said and "EA0B" not in said, said)
        check("and by the pointer", tab.page.get_attribute("[data-view=history]", "title") in said)
        tab.picture("alarm-1280")
        phone.picture("alarm-390-dark")
        tab.page.reload()
        tab.ready()
        check("it is there when the page is opened again", "⚠" in tab.text("[data-view=history]"))
        until_all_analysed(floor, 5)
        fresh = Tab(browser, floor.address)
        fresh.view("result")
        check("a fresh browser opens the run that was measured last, not that which was analysed last", fresh.page.input_value("#run") == "day-5", fresh.page.input_value("#run"))
        fresh.close()
        tab.view("history")
        tab.until("document.getElementById('changes')?.innerText.includes('outside its control limits')")
        check("History says which value", "EA0B" in tab.text("#changes"), tab.text("#changes"))
        tab.view("measure")
        tab.until("document.getElementById('service')?.innerText.includes('5 runs')")
        check("the disk is on the page", "GB free" in tab.text("#service"), tab.text("#service").replace("\n", " "))
        stays_while_another_run_ends(floor, tab, phone)
        tab.close()
        phone.close()


def until_all_analysed(floor, count):
    """So many runs have their report."""
    end = time.monotonic() + LIMIT_MS / 1000
    states = lambda: [json.loads(path.read_text())["state"] for path in pathlib.Path(floor.config).parent.rglob("*.state.json")]
    while sum(state in ("done", "not-judged") for state in states()) < count:
        if time.monotonic() > end:
            check(f"{count} runs are analysed", False, states())
        time.sleep(0.2)


def stays_while_another_run_ends(floor, tab, phone):
    """Whoever asks what if of day 3 stays there, with what is switched, while a cycle ends; the new run is offered."""
    tab.view("what-if")
    tab.page.select_option("#run", "day-3")
    tab.ready()
    tab.page.wait_for_selector("#rms")
    box = tab.page.locator("fieldset:has(> legend:text('Directions')) input").first
    box.uncheck()
    phone.view("measure")
    phone.page.select_option("#choose", "demo-static")
    phone.until("document.getElementById('choose').value === 'demo-static'")
    phone.page.click("#begin")
    phone.until("document.getElementById('cycle-state').innerText === 'Measuring'")
    floor.obey("run")
    phone.until("/^([3-9]|[0-9][0-9]+) of 336 poses/.test(document.querySelector('progress + p').innerText)")
    phone.page.focus("#abort")
    phone.page.keyboard.press("Enter")
    phone.page.keyboard.press("Enter")
    tab.until("!document.getElementById('news').hidden")
    said = tab.text("#news")
    check("the run that was analysed is offered", re.search(r"Run demo-static-\S+ was analysed\.", said) and "Show it" in said, said)
    check("the page stays at the run that is read, with its choices", tab.page.input_value("#run") == "day-3" and not box.is_checked(), tab.page.input_value("#run"))
    line = tab.page.locator("#run option").last.inner_text()
    check("in the list the moment of a run stands first", re.fullmatch(r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d UTC demo-static", line), line)
    wide = phone.page.locator("#run").bounding_box()["width"]
    check("and a phone has room for it", wide > 280, wide)
    phone.picture("news-390")
    tab.picture("news-1280")
    tab.page.get_by_role("button", name="Show it").click()
    tab.until("location.hash === '#result' && document.getElementById('run').value.startsWith('demo-static')")
    tab.ready()
    check("a press shows it", tab.page.locator("#news").is_hidden(), tab.text("h1"))


def history(browser, folder):
    runs = folder / "history"
    runs.mkdir()
    five_days(runs)
    engine = json.loads(trunnion("history", "--folder", runs, "--json"))
    with Served(runs) as address:
        tab = Tab(browser, address)
        tab.view("history")
        tab.page.get_by_text("Analyse 5 more").click()
        tab.page.wait_for_selector("#changes")
        tab.until("!document.getElementById('changes').innerText.includes('fitting both runs')")
        shown = tab.text("#changes")
        check("the change is the engine's, word for word", all(words in shown for words in engine["change"]["words"]), engine["change"]["words"])
        check("the alarm is there", "outside its control limits: direction of axis B about X (EA0B)" in tab.text("#changes"), engine["runs"][-1]["alarms"])
        chosen = tab.text("#parameter option[selected]")
        check("its chart is shown first, and the state before its name", "EA0B" in chosen and chosen.startswith("Outside its limits"), chosen)
        tab.page.set_viewport_size({"width": 390, "height": 844})
        wide = tab.page.evaluate("document.documentElement.scrollWidth - innerWidth")
        check("a value outside its limits makes the view no wider than a phone", wide <= 0, wide)
        tab.page.set_viewport_size({"width": 1280, "height": 800})
        # What the service leaves of a run when it makes room: the answers, and why.
        gone = runs / "day-0-20251123T141058Z"
        gone.with_name(gone.name + ".state.json").write_text((DATA / "state-removed.json").read_text())
        gone.with_name(gone.name + ".html").write_text("<h1>the report of day 0</h1>")
        tab.page.reload()
        tab.ready()
        tab.page.get_by_role("button", name=gone.name).click()
        tab.until("document.querySelector('#view .button')?.innerText === 'Its report'")
        check("a run whose samples are gone says so and has its report", "keep_days" in tab.text("main"), tab.text("main").splitlines()[-1])
        report = tab.page.request.get(f"{address}/api/runs/{gone.name}/report", headers={"host": address.split("//")[1]})
        check("which opens", "the report of day 0" in report.text(), report.status)
        tab.errors = [error for error in tab.errors if "410" not in error]
        tab.view("history")
        tab.page.wait_for_selector("#parameter")
        tab.page.click("#next-day")
        tab.until("document.getElementById('forecast').innerText.startsWith('No forecast of the next day: day-5 is outside its control limits')")
        check("a machine that changed has no forecast, and why", True, tab.text("#forecast"))
        tab.picture("history-limits")
        tab.guide("history", "#parameter")
        tab.page.get_by_text("A correction was entered into the control").click()
        tab.page.fill("#corrected-by", "Ada")
        tab.page.fill("#corrected-what", "lines of axis B")
        tab.page.get_by_role("button", name="It was entered now").click()
        tab.until("document.getElementById('notice').innerText.startsWith('The correction is kept')")
        check("a correction that was entered is shown", "Ada entered a correction" in tab.text("#corrections"), tab.text("#corrections .card"))
        kept = [json.loads(line) for line in (runs / "corrections.jsonl").read_text().splitlines()]
        check("and kept", [(one["machine"], one["by"], one["what"]) for one in kept] == [("table-bc", "Ada", "lines of axis B")], kept)
        tab.close()
