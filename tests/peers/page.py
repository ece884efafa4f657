#!/usr/bin/env python3
"""The page in headless Chromium over the real program: `page.py TRUNNION`. Every check prints a line; the first that fails ends it.

Nothing is compared by pixels. `PAGE_SHOTS=FOLDER` keeps a picture of every view, to be looked at; `PAGE_PICTURES=docs/use/pictures` writes
those of the guide, `PAGE_FIGURES=docs/measured/page.md` the figures of 10 000 poses. `PAGE_PART=many_poses` runs that part alone.
"""

import os
import pathlib
import tempfile

from playwright.sync_api import sync_playwright

from checks import check
from on_page.at_the_machine import at_the_machine
from on_page.by_token import by_token
from on_page.demo import demo_by_keyboard_and_by_mouse
from on_page.history import alarmed, history
from on_page.load import under_load
from on_page.many_poses import many_poses
from on_page.story import story_of_one_run
from on_page.widths import every_width, methods_on_a_screen

FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
         "--disable-background-networking", "--disable-component-update", "--disable-sync"]

with sync_playwright() as playwright:
    chromium = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=FLAGS)
    # Those of one line share a folder: the second and third show the recording of the first.
    parts = [
        [story_of_one_run, every_width, history], [methods_on_a_screen], [many_poses], [by_token], [alarmed], [under_load], [demo_by_keyboard_and_by_mouse], [at_the_machine],
    ]
    chosen = [part for part in parts if os.environ.get("PAGE_PART", part[0].__name__) == part[0].__name__]
    check("there is such a part", chosen, [part[0].__name__ for part in parts])
    for part in chosen:
        with tempfile.TemporaryDirectory() as temporary:
            for one in part:
                one(chromium, pathlib.Path(temporary))
    chromium.close()
