"""The demo by keyboard alone."""

import signal
import subprocess
import threading
import time

from checks import TRUNNION, check
from on_page.tab import Tab, rms_um


def demo_by_keyboard(browser, folder):
    """The demo: it measures, the person looks, asks, adds, sees the error fall; the mouse is not touched."""
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
        drain = threading.Thread(target=lambda: [None for _ in demo.stdout], daemon=True)
        drain.start()
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
        tab.close()
    finally:
        demo.send_signal(signal.SIGINT)
        demo.wait()


def press_until(tab, holds, most=80):
    """Tab until what has the focus is it; how often."""
    for presses in range(1, most):
        tab.page.keyboard.press("Tab")
        if tab.page.evaluate(holds):
            return presses
    check(f"Tab reaches {holds}", False)
