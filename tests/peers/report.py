#!/usr/bin/env python3
"""The report as PDF and as certificate, read back by programs of others: `report.py TRUNNION`. Every check prints a line; the first
that fails ends it.

The PDF is printed by Chromium and read by MuPDF. The certificate is judged by the rules that its publisher ships with dcclib, and by
the XML schema where that can be had: DCC_XSD names a copy that imports D-SI 2.2.1, else it is asked for at ptb.de. Without the schema one line says so.
`REPORT_SHOTS=FOLDER` keeps a picture of every page, to be looked at.
"""

import os
import pathlib
import re
import subprocess
import tempfile

import pymupdf
from dcclib.validation.schematron import SchematronValidator
from dcclib.validation.xsd import SchemaDownloadError, XsdValidator
from lxml import etree

from checks import check, trunnion

DATA = pathlib.Path(__file__).resolve().parents[1] / "data"
SHOTS = os.environ.get("REPORT_SHOTS")
# Letters of 7 pt can be read without a glass; MuPDF gives sizes to a hundredth.
SMALLEST_PT = 6.99
# As a person writes it: a part of it is not recorded.
CALIBRATION = """
[[calibration]]
sensor = "probe-1"
serial = "1702"
certificate = "K-2026-081"
date = 2026-01-12
[[calibration]]
sensor = "probe-2"
laboratory = "Example & Ltd"
"""
NAMESPACES = {"dcc": "https://ptb.de/dcc", "si": "https://ptb.de/si"}


def words(page):
    return " ".join(page.get_text().split())


def printed(pdf, first_page):
    document = pymupdf.open(pdf)
    pages = len(document)
    check("every reading is listed", pages >= 8, f"{pages} pages")
    for number, page in enumerate(document, 1):
        check(f"page {number} of {pages} is A4", [round(side) for side in page.rect[2:]] in ([595, 842], [594, 842], [596, 842]), page.rect)
        check(f"page {number} has its number", f"{number} / {pages}" in words(page))
        clipped = [word[4] for word in page.get_text("words") if word[0] < 28 or word[2] > page.rect.width - 28]
        check(f"page {number}: nothing leaves the margins", not clipped, clipped[:5])
        spans = [span for block in page.get_text("dict")["blocks"] for line in block.get("lines", []) for span in line["spans"]]
        small = [(span["text"], span["size"]) for span in spans if span["text"].strip() and span["size"] < SMALLEST_PT]
        check(f"page {number}: every letter can be read on paper", not small, small[:3])
        if SHOTS:
            page.get_pixmap(dpi=80).save(f"{SHOTS}/{pathlib.Path(pdf).stem}-{number:02}.png")
    top = words(document[0])
    for part in first_page:
        check(f"the first page has: {part}", part in top)
    heads = [number for number, page in enumerate(document, 1) if re.search(r"setup X \(mm\)", words(page))]
    check("the head of the long table repeats", len(heads) >= 3, heads)


def filled(document):
    """No page ends half way up, but the last one and the one before the annex; maps are on the page of their heading and scale."""
    said = [words(page) for page in document]
    annex = next(number for number, text in enumerate(said) if "Annex: every table" in text)
    for number, page in enumerate(document):
        if number + 1 in (annex, len(said)):
            continue
        foot = page.rect.height - 51
        marks = [block[3] for block in page.get_text("blocks")] + [drawing["rect"].y1 for drawing in page.get_drawings()]
        lowest = max(mark for mark in marks if mark < foot)
        check(f"page {number + 1} is not left half empty", lowest > 0.5 * page.rect.height, f"{lowest:.0f} of {page.rect.height:.0f} pt")
    alone = [number + 1 for number, text in enumerate(said) if "Residual before and after" in text and "— before" not in text]
    check("maps before and after are on the page of their heading", not alone, alone)


def schema():
    try:
        copy = os.environ.get("DCC_XSD")
        return XsdValidator.from_file(copy) if copy else XsdValidator.from_version("3.3.0")
    except SchemaDownloadError as unreachable:
        print(f"NOT JUDGED by the XML schema 3.3.0, which cannot be had here: {unreachable}")
        return None


def valid(dcc, schema):
    tree = etree.parse(dcc)
    judged = SchematronValidator.for_dcc().validate_file(str(dcc))
    check(f"{dcc.name}: the publisher's rules hold", judged.is_valid, [one.text for one in judged.failed_assertions])
    if schema:
        judged = schema.validate_tree(tree)
        check(f"{dcc.name}: the XML schema 3.3.0 holds", judged.is_valid, judged.__dict__)
    words = tree.xpath("//dcc:noQuantity//text()", namespaces=NAMESPACES)
    check(f"{dcc.name}: every quantity has a unit of D-SI", not words, words)
    return tree


def certified(tree):
    values = tree.xpath("//si:real[si:unit='\\metre']/si:value/text()", namespaces=NAMESPACES)
    check("lengths are in metres", values and all(abs(float(value)) < 1e-3 for value in values), values[:3])
    uncertain = tree.xpath("//si:real[.//si:valueStandardMU]", namespaces=NAMESPACES)
    check("parameters have standard uncertainties", len(uncertain) >= 8, len(uncertain))
    expanded = tree.xpath("//si:expandedMU/*[position() < 4]/text()", namespaces=NAMESPACES)
    check("the largest deviation has U with k = 2", expanded[1:] == ["2", "0.95"], expanded)
    stated = tree.xpath("//dcc:declaration/dcc:content[contains(., '(u ')]/text()", namespaces=NAMESPACES)
    u = float(re.search(r"\(u ([0-9.]+) µm\)", stated[0])[1])
    check("U is twice the u in words", abs(float(expanded[0]) * 1e6 - 2 * u) <= 0.01, (expanded[0], u))
    numbers = "//dcc:measuringEquipment[dcc:name/dcc:content='Sensor probe-1']//dcc:value/text()"
    numbers = tree.xpath(numbers, namespaces=NAMESPACES)
    check("a sensor has its serial number and certificate", numbers == ["1702", "K-2026-081"], numbers)
    check("the decision is there", tree.xpath("//dcc:conformity/text()", namespaces=NAMESPACES) == ["fail"])


def certificates(folder, schema):
    """Every kind of run that gets one, and those that get none."""

    def issued(name, runs, *options):
        given = ["--country", "DE", "--measured", "2026-02-28", *options]
        trunnion("report", *runs, "-o", folder / f"{name}.html", "--dcc", folder / f"{name}.xml", *given)
        return valid(folder / f"{name}.xml", schema)

    def imported(name, *options):
        run = folder / f"{name}.mcap"
        trunnion("import", DATA / name / "points.csv", "--setup", DATA / name / "setup.toml", "-o", run, *options)
        return run

    def says(tree, words):
        stated = tree.xpath("//dcc:declaration/dcc:content/text()", namespaces=NAMESPACES)
        check(f"a certificate says: {words}", any(words in one for one in stated), stated)

    gravity, drift, clear = (imported(name) for name in ["points-gravity", "points-backlash-and-drift", "points-nothing-hidden"])
    says(issued("missing", [gravity]), "The model is not complete")
    says(issued("clear", [clear]), "No effect is missing from the model")
    says(issued("on-the-fly", [imported("sweep-out-of-step", "--kind", "on-the-fly")]), "cannot say whether an effect is missing")
    issued("two-runs", [clear, drift])
    model = folder / "drift.toml"
    trunnion("add", "thermal-drift", drift, "--model", model)
    tree = issued("drift", [drift], "--model", model)
    units = tree.xpath("//dcc:quantity[contains(dcc:name/dcc:content, 'tau1_s')]//si:unit/text()", namespaces=NAMESPACES)
    check("a drift has its time constant", units == ["\\second"], units)
    names = [etree.parse(one).xpath("//dcc:uniqueIdentifier/text()", namespaces=NAMESPACES)[0] for one in folder.glob("*.xml")]
    issued("wider", [gravity], "--tolerance-um", "50", "--laboratory", " A  <&> ", "--customer", "B\"'\n", "--operator", "\t", "--serial", "")
    names += etree.parse(folder / "wider.xml").xpath("//dcc:uniqueIdentifier/text()", namespaces=NAMESPACES)
    check("no two certificates have one identifier", len(set(names)) == len(names) >= 6, names)
    none = ["report", gravity, "-o", folder / "none.html", "--dcc", folder / "none.xml"]
    trunnion(*none, "--measured", "2026-02-28", code=2)
    trunnion(*none, "--country", "DE", code=1)
    check("without country or day there is no certificate", not (folder / "none.xml").exists())


with tempfile.TemporaryDirectory() as temporary:
    folder = pathlib.Path(temporary)
    points, run, model = DATA / "points-gravity", folder / "run.mcap", folder / "model.toml"
    setup = folder / "setup.toml"
    setup.write_text((points / "setup.toml").read_text() + CALIBRATION)
    trunnion("import", points / "points.csv", "--setup", setup, "-o", run)
    trunnion("add", "gravity-sag:B", run, "--model", model)
    common = ["report", run, "--model", model, "--tolerance-um", "12", "--operator", "Ada", "--serial", "SN 7"]
    trunnion(*common, "-o", folder / "en.html", "--pdf", folder / "en.pdf", "--dcc", folder / "en.xml", "--measured", "2026-02-28", "--country", "DE")
    printed(folder / "en.pdf", ["The model now explains this machine", "SN 7", "Ada", "fail", "pass", "What to do", "How sure", "0.94 µm", "0.34 µm", "probe-1: 1702, K-2026-081, 2026-01-12"])
    filled(pymupdf.open(folder / "en.pdf"))
    trunnion("report", run, "-o", folder / "before.html", "--pdf", folder / "before.pdf")
    filled(pymupdf.open(folder / "before.pdf"))
    rules = schema()
    certified(valid(folder / "en.xml", rules))
    german = ["--language", "de", "--dcc", folder / "de.xml", "--measured", "2026-02-28", "--country", "DE"]
    trunnion(*common, "-o", folder / "de.html", "--pdf", folder / "de.pdf", *german)
    check("a certificate has one language", (folder / "de.xml").read_bytes() == (folder / "en.xml").read_bytes())
    (folder / "de.xml").unlink()
    top = words(pymupdf.open(folder / "de.pdf")[0])
    check("the German first page is German", all(part in top for part in ["nicht bestanden", "Seriennummer", "Was zu tun ist"]), top[:200])
    # By fontconfig, which the browser asks: what the browser drew is not looked at here.
    has_font = bool(subprocess.run(["fc-list", ":lang=ja", "family"], capture_output=True, text=True, check=True).stdout.strip())
    said = trunnion(*common, "-o", folder / "ja.html", "--pdf", folder / "ja.pdf", "--language", "ja", code=0 if has_font else 3)
    check(f"a PDF {'with' if has_font else 'without'} Japanese characters says so", ("no font" in said) != has_font, said)
    certificates(folder, rules)
