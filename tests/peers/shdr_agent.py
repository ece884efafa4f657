"""An agent's reader of SHDR, written from the standard alone: `shdr_agent.py PORT`. Prints what it took as one line of JSON.

Holds every item against the device file that ships (config/mtconnect/trunnion.xml), every value against the words of MTConnect 2.2 for
the type of its item, and the answer to a ping against the protocol. What does not fit ends it.
"""

import datetime
import json
import pathlib
import re
import socket
import sys
import xml.etree.ElementTree as xml

ROOT = pathlib.Path(__file__).resolve().parents[2]
# MTConnect 2.2: values of the types, and keys of a row of FEATURE_MEASUREMENT with their values.
EVENTS = {
    "AVAILABILITY": {"AVAILABLE", "UNAVAILABLE"},
    "EXECUTION": {"READY", "ACTIVE", "INTERRUPTED", "FEED_HOLD", "STOPPED", "OPTIONAL_STOP", "PROGRAM_STOPPED", "PROGRAM_COMPLETED",
                  "WAIT", "PROGRAM_OPTIONAL_STOP", "UNAVAILABLE"},
    "PROGRAM": None,
}
LEVELS = {"NORMAL", "WARNING", "FAULT", "UNAVAILABLE"}
CELLS = {
    "MEASUREMENT_ID": str, "MEASUREMENT_TYPE": {"POINT", "RADIUS", "ANGLE", "LENGTH"}, "MEASUREMENT_VALUE": float,
    "MEASUREMENT_UNITS": {"MILLIMETER", "MICRO_RADIAN", "DEGREE"}, "UNCERTAINTY": float, "UNCERTAINTY_TYPE": {"COMBINED", "MEAN"},
}
RESETS = {"MANUAL", "DAY", "SHIFT", "LIFE", "YEAR", "MONTH", "WEEK", "ACTION_COMPLETE", "ANNUAL", "MAINTENANCE", "POWER_ON"}


def device():
    document = xml.parse(ROOT / "config/mtconnect/trunnion.xml")
    name = "{urn:mtconnect.org:MTConnectDevices:2.2}DataItem"
    return {item.get("id"): item.attrib for item in document.iter(name)}


def table(text):
    """`:RESET name={KEY=value …} …`"""
    reset, rest = re.fullmatch(r"(?::([A-Z_]+) )?(.*)", text).groups()
    assert reset in RESETS, reset
    rows = {}
    while rest:
        row, cells, rest = re.fullmatch(r"\s*([A-Za-z0-9_]+)=\{((?:[^'{}]|'[^']*')*)\}(.*)", rest).groups()
        rows[row] = {}
        for key, quoted, bare in re.findall(r"([A-Z_]+)=(?:'([^']*)'|(\S+))", cells):
            kind, value = CELLS[key], quoted or bare
            rows[row][key] = float(value) if kind is float else value
            assert kind in (str, float) or value in kind, (key, value)
    return rows


def value(item, cells):
    kind, category = item["type"], item["category"]
    if category == "CONDITION":
        level, _code, _severity, _qualifier, text = cells
        assert level in LEVELS, level
        return [level, text]
    if kind == "MESSAGE":
        code, text = cells
        return [code, text]
    (text,) = cells
    if item.get("representation") == "TABLE":
        return text if text == "UNAVAILABLE" else table(text)
    assert EVENTS[kind] is None or text in EVENTS[kind], (kind, text)
    return text


items, found = device(), {}
with socket.create_connection(("127.0.0.1", int(sys.argv[1])), timeout=30) as adapter:
    lines = adapter.makefile("rw", encoding="utf-8", newline="\n")
    while found.keys() != items.keys():
        stamp, name, *cells = lines.readline().rstrip("\n").split("|")
        age = datetime.datetime.now(datetime.timezone.utc) - datetime.datetime.fromisoformat(stamp.replace("Z", "+00:00"))
        assert abs(age.total_seconds()) < 60, stamp
        found[name] = value(items[name], cells)
    lines.write("* PING\n")
    lines.flush()
    assert re.fullmatch(r"\* PONG \d+\n", lines.readline())
print(json.dumps(found), flush=True)
