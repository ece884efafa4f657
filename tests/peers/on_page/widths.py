"""Every view on a screen, a tablet and a phone: nothing scrolls sideways, targets and letters are large enough, axe finds nothing serious."""

from checks import check, trunnion
from on_page.tab import DATA, Served, Tab, accessible

VIEWS = ["result", "what-if", "history", "measure"]


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
                tab.accessible(f"{view} at {width}, {scheme}")
                tab.picture(f"{view}-{width}-{scheme}")
                readable(tab, f"{view} at {width}")
            tab.close()


def methods_on_a_screen(browser, folder):
    """Every table of a page of a named method is whole on a screen, without a scroll."""
    config = DATA.parents[1] / "config"
    for plane in ["xy", "yz", "zx"]:
        trunnion("simulate", config / "truths/three-axis-circles.toml", "--cycle", config / f"cycles/circle-{plane}.toml", "-o", folder / f"{plane}.mcap")
    points = DATA / "points-gravity"
    trunnion("import", points / "points.csv", "--setup", points / "setup.toml", "-o", folder / "grid.mcap")
    for method, runs in [("circular", ["xy", "yz", "zx"]), ("error-map", ["grid"])]:
        html = folder / f"{method}.html"
        trunnion("identify", *(folder / f"{run}.mcap" for run in runs), "--method", method, "--html", html)
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.goto(html.as_uri())
        cut = page.evaluate("""() => [...document.querySelectorAll('.scroll')].filter((one) => one.scrollWidth > one.clientWidth)
            .map((one) => [one.querySelector('caption').textContent, one.scrollWidth, one.clientWidth])""")
        check(f"{method}: no table is cut on a screen", not cut, cut)
        accessible(page, f"the page of {method}")
        page.close()


def readable(tab, where):
    """Letters in charts are 11 px high at least, numbers in cells 10, also in closed parts; what is drawn by a script is drawn at the size it is shown."""
    tab.page.evaluate("document.querySelectorAll('#view details').forEach((part) => (part.open = true))")
    tab.page.wait_for_timeout(300)
    small = tab.page.evaluate("""() => [...document.querySelectorAll('#view svg text')].filter((one) => one.checkVisibility())
        .map((one) => [one.textContent, parseFloat(getComputedStyle(one).fontSize) * one.getScreenCTM().a, one.classList.contains('cell') ? 10 : 11])
        .filter(([, px, least]) => px < least)""")
    check(f"{where}: letters in charts are 11 px high", not small, small[:3])
    sizes = tab.page.evaluate("""() => [...document.querySelectorAll('#view svg text:not(.cell)')].filter((one) => one.checkVisibility())
        .map((one) => [parseFloat(getComputedStyle(one).fontSize) * one.getScreenCTM().a, one.textContent])""")
    ends = [min(sizes), max(sizes)] if sizes else [[1, ""], [1, ""]]
    check(f"{where}: no chart has letters much larger than the others", ends[1][0] <= 1.35 * ends[0][0], ends)
    scaled = tab.page.evaluate("""() => [...document.querySelectorAll('.map canvas')].filter((one) => one.clientWidth)
        .map((one) => [one.getAttribute('aria-label'), one.width / devicePixelRatio, one.clientWidth]).filter(([, drawn, shown]) => Math.abs(drawn - shown) > 1)""")
    check(f"{where}: drawings are not scaled", not scaled, scaled[:2])
