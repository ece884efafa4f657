"""A run of one machine: the result is the engine's, an effect is added and removed, a report is filed."""

import json
import pathlib
import re

from checks import check, trunnion
from on_page.tab import DATA, Served, Tab, accessible, rms_um
from on_page.what_if import together, what_if


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

        order = ["How sure this is", "What to do", "Where the model fails most", "Residual over", "Which effect, and why", "The model: what was added", "What is missing from the data"]
        heads = tab.page.locator("#view h2").all_inner_texts()
        places = [next((k for k, head in enumerate(heads) if head.startswith(part)), None) for part in order]
        check("the result has its parts in order", None not in places and places == sorted(places), heads)
        tab.guide("result", height=800)
        twice = tab.page.evaluate("""() => [...document.querySelectorAll('#view details')].map((part) => {
            part.open = true;
            part.dispatchEvent(new Event('toggle'));
            return part;
        }).filter((part) => part.querySelector('div h2')).map((part) => [part.querySelector('h2').innerText, part.querySelector('div h2').innerText])""")
        check("no part that opens has a second heading of its kind", not twice, twice)
        together(tab)

        # By mouse, without a name first.
        tab.page.click('[data-add="gravity-sag:B"]')
        check("nobody adds without a name", "Who does it?" in tab.text("#notice"), tab.text("#notice"))
        tab.page.fill("#who", "Ada")
        tab.page.click('[data-add="gravity-sag:B"]')
        tab.page.wait_for_selector('[data-remove="gravity-sag:B"]')
        after = rms_um(tab.text(".facts dd"))
        ladder = json.loads(trunnion("ladder", "--model", model, "--json"))["rows"][-1]["ladder"]
        check("the rms falls", after < before, (before, after))
        check("it equals trunnion ladder", abs(after - ladder["error_after_um"]) < 0.006, ladder["error_after_um"])
        check("the name is kept", ladder["by"] == "Ada" and "Ada" in tab.text(".steps"), tab.text(".steps li"))
        found = tab.page.locator("section:has(> h2:text('Found and added'))").inner_text()
        kept = ["gravity-sag:B", "Where the model failed before it was added", "Likely cause", "It is significant", "Added by Ada on", "the residual falls from", "— before", "— after"]
        check("what was found stays after the addition", all(part in found for part in kept), [part for part in kept if part not in found])
        tab.picture("result-added")
        other.page.wait_for_selector('[data-remove="gravity-sag:B"]')
        check("the other browser shows it", "another window" in other.text("#notice"), other.text("#notice"))

        report_to_be_filed(tab, run, model)
        what_if(tab, after, before)
        sources_are_names(tab, address)

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
        ladder = json.loads(trunnion("ladder", "--model", model, "--json"))
        check("the model holds it no more", all(row["effect"] != "gravity-sag:B" for row in ladder["rows"]))
        check("who removed it is kept", ladder["removed"][0]["by"] == "Ada" and "removed by Ada" in tab.text(".steps"), ladder["removed"])
        tab.close()
        other.close()


def report_to_be_filed(tab, run, model):
    """A button makes what `trunnion report` makes, to be downloaded as page and PDF."""
    tab.page.fill("#operator", "Ada")
    tab.page.select_option("#language", "de")
    tab.page.click("#file")
    tab.until("/Kept as|not written/.test(document.getElementById('filed').innerText)")
    said = tab.text("#filed")
    filed = run.with_suffix(".report.html")
    check("the report is filed next to the recording", str(filed) in said and filed.exists(), said)
    same = run.with_name("by-the-command.html")
    trunnion("report", run, "--model", model, "--operator", "Ada", "--language", "de", "-o", same)
    paper = tab.context.new_page()
    paper.goto(same.as_uri())
    accessible(paper, "the report")
    paper.close()
    check("it is the report of the command, byte for byte", filed.read_bytes() == same.read_bytes(), filed.stat().st_size)
    with tab.page.expect_download() as page:
        tab.page.get_by_role("link", name="Download the page").click()
    check("the page is downloaded", pathlib.Path(page.value.path()).read_bytes() == filed.read_bytes(), page.value.suggested_filename)
    with tab.page.expect_download() as printed:
        tab.page.get_by_role("link", name="Download the PDF").click()
    pdf = pathlib.Path(printed.value.path()).read_bytes()
    check("so is the PDF", pdf.startswith(b"%PDF-") and printed.value.suggested_filename == "gravity.report.pdf", len(pdf))
    tab.picture("result-filed")


def sources_are_names(tab, address):
    """Nothing that is shown names a paper by its key, nor a document of the repository."""
    ask = lambda path: tab.page.request.get(f"{address}/api/runs/gravity{path}", headers={"host": address.split("//")[1]}).text()
    methods = [line["name"] for line in json.loads(ask("/methods"))["methods"] if not line["problem"]]
    check("some methods have a page", methods, methods)
    for path in ["", "/report", "/trial/backlash:C", "/methods", *(f"/method/{name}" for name in methods)]:
        shown = re.findall(r"\bS[0-4]\b.{0,30}|docs/design/.{0,30}", ask(path))
        check(f"gravity{path}: sources are author, year, title", not shown, shown[:3])
