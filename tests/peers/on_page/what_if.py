"""What if: effects on and off, curves over each other, one selection for maps, chart and table."""

import re

from checks import check


def what_if(tab, after, before):
    tab.view("what-if")
    tab.page.wait_for_selector("#rms")
    shown = lambda: float(tab.page.locator("#rms").get_attribute("data-um"))
    check("what-if begins at the fit", abs(shown() - after) < 0.006, shown())
    tab.page.uncheck('input[value="gravity-sag:B"]')
    check("without the effect it is the fit without it", abs(shown() - before) < 0.006, shown())
    check("and says so", f"{before:.2f} µm" in tab.text("#rms + p"), tab.text("#rms + p"))
    widths = lambda: tab.page.evaluate("[...document.querySelectorAll('.residual-bars .fill')].map((one) => parseFloat(one.style.width))")
    without = tab.text(".residual-bars [aria-current]")
    check("the bars follow: chosen now is the fit without it", "without" in without and abs(widths()[0] - max(widths())) < 0.5, (without, widths()))
    tab.page.check('input[value="gravity-sag:B"]')
    check("and fall when it is on", widths()[0] < 0.6 * max(widths()), widths())
    curves(tab)
    check("and back", abs(shown() - after) < 0.006, shown())
    selection_on_curves(tab)
    tab.page.uncheck('input[value="low"]')
    check("a setup can be left out", "chosen setups" in tab.text("#rms + p"))
    tab.page.check('input[value="low"]')
    linked(tab)
    tab.page.get_by_text("Try an expression").click()
    tab.page.fill("#expression", "k*sin(B_deg)")
    tab.until("document.body.innerText.includes('B_deg')")
    tab.page.fill("#expression", "k*cos(3*B)")
    tab.until("document.body.innerText.includes('--expression \"k*cos(3*B)\"')")
    check("an expression is checked as it is typed", True)
    typed(tab, shown)


def typed(tab, shown):
    """An expression is fitted next to the model, and switched as an effect of the catalogue."""
    alone = shown()
    tab.page.get_by_role("button", name="Fit it and switch it on").click()
    box = tab.page.locator('input[value="axis:B dx: k*cos(3*B)"]')
    box.wait_for()
    with_it = shown()
    check("an expression that was typed is fitted and on", box.is_checked() and with_it <= alone + 1e-3, (with_it, alone))
    check("and the figure is that of its fit", "The fit of this set" in tab.text("#rms + p"), tab.text("#rms + p"))
    box.uncheck()
    check("it is switched off again", abs(shown() - alone) < 1e-9, (shown(), alone))


def together(tab):
    """Candidates in pairs: their sizes are fitted together, so that two never leave more than the better one."""
    tab.view("what-if")
    tab.page.wait_for_selector("#rms")
    shown = lambda: float(tab.page.locator("#rms").get_attribute("data-um"))
    boxes = tab.page.locator("#view fieldset").first.locator("input")
    candidates = [box for box in boxes.all() if not box.is_checked()][:3]
    alone = []
    for box in candidates:
        box.check()
        alone.append(shown())
        box.uncheck()
    check("there are candidates to combine", len(candidates) >= 2, alone)
    for i, one in enumerate(candidates):
        for j in range(i):
            one.check()
            candidates[j].check()
            both = shown()
            check("two effects leave no more than the better one", both <= min(alone[i], alone[j]) + 1e-3, (alone[i], alone[j], both))
            check("and the page says what the figure is", "sizes fitted together" in tab.text("#rms + p"), tab.text("#rms + p"))
            one.uncheck()
            candidates[j].uncheck()
    tab.view("result")


def curves(tab):
    """Two curves laid over each other, for every choice; a finger on a map selects."""
    section = tab.page.locator("#overlay")
    said = lambda: tab.text("#apart")
    apart = lambda: float(re.search(r"they are ([0-9.]+) µm", said())[1])
    opened, sizes = apart(), []
    for choice in tab.page.evaluate("""() => {
        const values = (id) => [...document.querySelectorAll(`#${id} option`)].map((one) => one.value);
        return values('against').flatMap((a) => values('along').flatMap((b) => values('of').map((c) => [a, b, c])));
    }"""):
        for name, value in zip(["against", "along", "of"], choice):
            tab.page.select_option(f"#{name}", value)
        sizes.append(apart())
    check("two curves open where they are furthest apart", opened == max(sizes) > min(sizes), (opened, sizes))
    texts = set()
    for k, title in enumerate(tab.page.locator("#against option").all_inner_texts()):
        tab.page.select_option("#against", str(k))
        check(f"{title}: two curves", section.locator(".u-series").count() >= 3 and "µm apart at most" in said(), said())
        texts.add(said())
    check("each choice has curves of its own", len(texts) == tab.page.locator("#against option").count() >= 2, texts)
    canvas = tab.page.locator(".map canvas").first
    # Half a page is scrolled by a finger on it: only a tap selects.
    box = canvas.bounding_box()
    tab.page.evaluate("""([x, y]) => {
        const on = document.querySelector('.map canvas');
        for (const name of ['pointermove', 'click']) on.dispatchEvent(new PointerEvent(name, { bubbles: true, pointerType: 'touch', clientX: x, clientY: y }));
    }""", [box["x"] + 0.6 * box["width"], box["y"] + 0.5 * box["height"]])
    check("a tap on a map selects", "Pose " in tab.text("#selected"), tab.text("#selected").splitlines()[0])


def selection_on_curves(tab):
    """A click on the curves selects a place in all plots, and a row of the table marks its place on the curves."""
    tab.page.select_option("#along", label="C")
    curves = tab.page.locator("#overlay .u-over")
    curves.scroll_into_view_if_needed()
    box = curves.bounding_box()
    tab.page.mouse.click(box["x"] + 0.4 * box["width"], box["y"] + 0.5 * box["height"])
    place = re.search(r"C (−?[0-9.]+°)", tab.text("#places"))
    check("a click on the curves selects a place", place and f"C {place[1]}" in tab.text("#selected"), (tab.text("#places"), tab.text("#selected")[:200]))
    check("and the maps mark its cells", "cells are selected" in tab.text(".map canvas + p"), tab.text(".map canvas + p"))
    tab.page.locator(".map canvas").first.focus()
    tab.page.keyboard.press("ArrowRight")
    under = re.search(r"C (−?[0-9.]+°)", tab.text(".map canvas + p"))[1]
    check("a cell of a map marks its place on the curves", f"C {under}" in tab.text("#places"), (under, tab.text("#places")))


def linked(tab):
    """One selection for maps, chart, arrows and table, by keyboard and by mouse."""
    tab.page.locator(".map canvas").first.focus()
    tab.page.keyboard.press("ArrowRight")
    tab.page.keyboard.press("ArrowRight")
    under = tab.page.locator(".map canvas + p")
    texts = under.all_inner_texts()
    check("arrow keys mark the same cell in every map", len({text.split(":")[0] for text in texts}) == 1 and "µm" in texts[-1], texts)
    said = tab.text("#selected")
    check("its poses are said with pose and value", "Pose " in said and "µm" in said, said.splitlines()[0])
    tab.page.get_by_text("Every pose").click()
    first = tab.page.locator("table button").first
    number = first.inner_text()
    first.click()
    check("a row selects its pose", f"Pose {number}," in tab.text("#selected"), tab.text("#selected"))
    cells = dict(zip(tab.page.locator("#view table th").all_inner_texts()[-5:], tab.page.locator("tr.chosen td").all_inner_texts()[-5:]))
    marked = re.findall(r"([BC]) (−?[0-9.]+)°", under.first.inner_text().split(":")[0])
    same = all(float(at.replace("−", "-")) == float(cells[f"{axis}, °"].replace("−", "-")) for axis, at in marked)
    check("the maps mark it too", len(marked) == 2 and same, (marked, cells))
    check("the row is marked", tab.page.locator("tr.chosen button").first.inner_text() == number)
    before = tab.text(".soft[role=status]")
    tab.page.locator("#magnification").focus()
    tab.page.keyboard.press("ArrowRight")
    check("the magnification is said", "Magnification" in before and tab.text(".soft[role=status]") != before, tab.text(".soft[role=status]"))
    widths = lambda: tab.page.evaluate("[...document.querySelectorAll('.uplot')].map((one) => one.clientWidth)")
    on_screen = widths()
    tab.page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    on_paper = widths()
    tab.page.evaluate("window.dispatchEvent(new Event('afterprint'))")
    check("a chart is no wider than the paper, and as wide as before after it", on_paper and max(on_paper) <= 660 and widths() == on_screen, (on_screen, on_paper))
    tab.picture("what-if-linked")
    tab.guide("what-if", "#rms")
