"""What the parts share: a tab of the browser whose errors fail the test, the program that serves it, simulated devices."""

import os
import pathlib
import re
import subprocess
import time

import pymupdf
from axe_playwright_python.sync_playwright import Axe

from checks import TRUNNION, check

DATA = pathlib.Path(__file__).resolve().parents[2] / "data"
SHOTS = os.environ.get("PAGE_SHOTS")
PICTURES = os.environ.get("PAGE_PICTURES")
# A repository keeps every version of a picture.
LARGEST_PICTURE = 150_000
SHOP_FLOOR = pathlib.Path(TRUNNION).with_name("shop-floor")
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


class Floor:
    """Simulated devices, and the service that reads them, until the end of the block."""

    def __init__(self, folder, khz=1, token=None, recorded=lambda recordings: None):
        self.floor = subprocess.Popen([SHOP_FLOOR, folder, str(khz)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.config = self.floor.stdout.readline().strip()
        recordings = pathlib.Path(self.config).parent / re.search('^recordings = "(.*)"', pathlib.Path(self.config).read_text(), re.M)[1]
        recordings.mkdir(exist_ok=True)
        recorded(recordings)
        if token:
            self.let_others_in(token)
        self.log = open(folder / "service.log", "w+")
        self.service = subprocess.Popen([TRUNNION, "daemon", "--config", self.config], stderr=self.log)
        end = time.monotonic() + 60
        self.address = None
        while not self.address and time.monotonic() < end:
            time.sleep(0.1)
            said = (folder / "service.log").read_text()
            self.address = next((word for word in said.split() if word.startswith(("http://127.0.0.1:", "https://127.0.0.1:"))), None)
        check("the service says where its page is", self.address, self.address)

    def let_others_in(self, token):
        config = pathlib.Path(self.config)
        for name in ["page.crt", "page.key"]:
            (config.parent / name).write_bytes((DATA.parents[1] / "crates/service/tests/data" / name).read_bytes())
        (config.parent / "page-token").write_text(token)
        page = '[page]\ncertificate = "page.crt"\nkey_file = "page.key"\ntoken_file = "page-token"\n'
        config.write_text(config.read_text().replace("[page]\n", page))

    def obey(self, line):
        self.floor.stdin.write(line + "\n")
        self.floor.stdin.flush()
        check(f"the floor obeys: {line}", self.floor.stdout.readline().strip() == "ok")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.service.terminate()
        self.service.wait()
        self.floor.stdin.close()
        self.floor.wait()


class Tab:
    """A page whose errors fail the test."""

    def __init__(self, browser, address, width=1280, height=800, scheme="light"):
        self.context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme, ignore_https_errors=True)
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
                check(f"within {LIMIT_MS // 1000} s: {holds}", False, (self.text("body"), self.errors))
            self.page.wait_for_timeout(50)

    def ready(self):
        self.until("document.getElementById('view')?.getAttribute('aria-busy') === 'false'")

    def text(self, selector):
        return self.page.locator(selector).first.inner_text()

    def accessible(self, where):
        accessible(self.page, where)

    def picture(self, name):
        if SHOTS:
            self.page.screenshot(path=f"{SHOTS}/{name}.png", full_page=True)

    def guide(self, name, top="h1", height=720):
        """What a person sees on a screen that begins here, for the guide."""
        if PICTURES:
            path = pathlib.Path(PICTURES) / f"{name}.png"
            self.page.evaluate("top => window.scrollTo(0, document.querySelector(top).offsetTop - 120)", top)
            shot = self.page.screenshot(clip={"x": 0, "y": 0, "width": 1280, "height": height})
            # The same pixels in fewer bytes than the browser writes.
            path.write_bytes(pymupdf.Pixmap(shot).tobytes("png"))
            check(f"{path} is small", path.stat().st_size <= LARGEST_PICTURE, path.stat().st_size)

    def close(self):
        check("no error on the console", not self.errors, self.errors)
        self.context.close()


def accessible(page, where):
    """axe is a well-kept tool; what it calls serious or critical keeps somebody from using the page."""
    found = Axe().run(page).response["violations"]
    grave = [(one["id"], one["nodes"][0]["html"][:120]) for one in found if one["impact"] in ("serious", "critical")]
    check(f"{where}: axe finds nothing serious", not grave, grave)


def rms_um(text):
    return float(text.split()[0])
