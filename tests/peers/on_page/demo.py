"""The demo by keyboard alone, and by mouse alone."""

import signal
import subprocess
import time

from checks import TRUNNION, check
from on_page.tab import Tab, rms_um


def demo_by_keyboard_and_by_mouse(browser, folder):
    """The demo: it measures, the person looks, asks, adds, sees the error fall; the mouse is not touched. Then another does it without the keyboard."""
    arguments = [TRUNNION, "demo", "--page", "--static-only", "--hidden", "gravity-sag:B", "--output", str(folder)]
    demo = subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True)
    began = time.monotonic()
    try:
        address = next(line.split()[-1] for line in demo.stdout if line.startswith("Watch it at"))
        tab = Tab(browser, address)
        tab.view("measure")
        tab.until("document.querySelectorAll('[role=meter]').length === 3")
        check("the demo shows live values", "mm from its centre" in tab.text("main"))
        tab.until("document.getElementById('cycle-state').innerText === 'Measuring'")
        tab.until("document.querySelector('#view progress').value > 20")
        tab.picture("demo-measure")
        tab.accessible("the demo while it measures")
        # What the terminal does at its end is done: from here on nobody but the person changes the model.
        printed = []
        for line in demo.stdout:
            printed.append(line)
            if "The page stays at" in line:
                break
        check("the truth stays sealed", "The page stays at" in printed[-1] and not any("Hidden:" in line for line in printed), printed)
        model = folder / "static.model.toml"
        check("the terminal adds nothing", not model.exists(), printed)
        tab.until("document.getElementById('cycle-state').innerText === 'The cycle is done'")
        press_until(tab, "document.activeElement.dataset.view === 'result'")
        tab.page.keyboard.press("Enter")
        tab.until("document.querySelector('#view h1')?.innerText.includes('gravity-sag:B')")
        before = rms_um(tab.text(".facts dd"))
        press_until(tab, "document.activeElement.id === 'who'")
        tab.page.keyboard.type("Ada")
        press_until(tab, "document.activeElement.dataset.add === 'gravity-sag:B'")
        tab.page.keyboard.press("Enter")
        tab.page.wait_for_selector('[data-remove="gravity-sag:B"]')
        after = rms_um(tab.text(".facts dd"))
        check("by keyboard alone the error falls", after < before, f"{before} to {after} µm, {time.monotonic() - began:.0f} s after the start")
        check("the person added it", 'by = "Ada"' in model.read_text(), model.read_text()[-200:])
        tab.accessible("the demo after the addition")
        by_mouse(tab.context.new_page(), address, tab, before, after)
        tab.close()
        demo.send_signal(signal.SIGINT)
        ended = demo.stdout.read()
        check("then the seal is broken", "Found: gravity-sag:B, added by Ada." in " ".join(ended.split()), ended)
    finally:
        demo.send_signal(signal.SIGINT)
        demo.wait()


def by_mouse(page, address, other, before, after):
    """A second window of the same person: their name is known, so that a mouse suffices."""
    page.goto(f"{address}/#measure")
    page.click('nav [data-view="result"]')
    page.click('[data-remove="gravity-sag:B"]')
    page.wait_for_selector('[data-add="gravity-sag:B"]')
    rose = rms_um(page.locator(".facts dd").first.inner_text())
    check("by mouse alone the effect is removed, and the error is what it was", rose == before, (before, rose))
    page.click('[data-add="gravity-sag:B"]')
    page.wait_for_selector('[data-remove="gravity-sag:B"]')
    fell = rms_um(page.locator(".facts dd").first.inner_text())
    check("by mouse alone the error falls again", fell == after, (after, fell))
    other.page.wait_for_selector('[data-remove="gravity-sag:B"]')
    page.close()


def press_until(tab, holds, most=80):
    """Tab until what has the focus is it; how often."""
    for presses in range(1, most):
        tab.page.keyboard.press("Tab")
        if tab.page.evaluate(holds):
            return presses
    check(f"Tab reaches {holds}", False)
