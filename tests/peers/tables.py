#!/usr/bin/env python3
"""Tables of recordings read by programs of others: `tables.py TRUNNION`. Every check prints a line; the first that fails ends it.

What `export parquet` wrote is compared with `export csv` of each recording, through pandas, Polars and DuckDB. Then the questions of
docs/use/tables.md are asked of a few machines of our own export, and of 10 000 generated ones, whose answers are known.
"""

import io
import json
import pathlib
import re
import tempfile
import time

import duckdb
import numpy
import pandas
import polars

from checks import check, trunnion

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = ROOT / "tests/data"
RUNS = ["points-gravity", "points-nothing-hidden"]
OF_RUN = ["machine", "serial", "run", "began"]


def read_back(folder):
    for run in RUNS:
        points = DATA / run
        trunnion("import", points / "points.csv", "--setup", points / "setup.toml", "-o", folder / f"{run}.mcap")
    recordings = [folder / f"{run}.mcap" for run in RUNS]
    for what in ["points", "residuals", "effects", "parameters", "runs"]:
        file = folder / f"{what}.parquet"
        trunnion("export", "parquet", *recordings, "--what", what, "-o", file)
        csv = [pandas.read_csv(io.StringIO(trunnion("export", "csv", path, "--what", what))) for path in recordings]
        one = pandas.concat([table.assign(run=run) for run, table in zip(RUNS, csv)], ignore_index=True)
        for reader, table in [
            ("pandas", pandas.read_parquet(file)),
            ("Polars", polars.read_parquet(file).to_pandas()),
            ("DuckDB", duckdb.sql(f"SELECT * FROM '{file}'").df()),
        ]:
            check(f"{reader} reads the {what} with their run", list(table.columns[:4]) == OF_RUN, list(table.columns))
            same = len(table) == len(one) and set(table.run) == set(RUNS) and set(table.machine) == {"table-bc"}
            check(f"{reader} reads every row", same, f"{len(table)} of {len(one)}")
            for column in one.columns:
                ours, theirs = one[column], table[column]
                if pandas.api.types.is_numeric_dtype(ours):
                    equal = numpy.array_equal(ours.astype(float), theirs.astype(float), equal_nan=True)
                else:
                    equal = [None if pandas.isna(cell) else cell for cell in ours] == [None if pandas.isna(cell) else cell for cell in theirs]
                check(f"{reader}: {what}.{column} is that of the CSV", equal)


def ask(folder):
    """What the two questions of the guide find in the tables of a folder."""
    shared, drifting = re.findall(r"```sql\n(.*?)```", (ROOT / "docs/use/tables.md").read_text(), re.S)
    answer = lambda question: duckdb.sql(re.sub(r"'(\w+\.parquet)'", rf"'{folder}/\1'", question)).df()
    return answer(shared), answer(drifting)


def own(folder):
    """Four machines as we export them: a person added the sag of one, the service found that of another, which has no serial number."""
    def measured(name, points, serial):
        at = folder / name
        at.mkdir(parents=True)
        head = f'serial = "{serial}"\n' if serial else ""
        (at / "machine.toml").write_text(head + (ROOT / "config/machines/table-bc.toml").read_text())
        setup = (DATA / points / "setup.toml").read_text().replace('"table-bc"', '"machine.toml"')
        (at / "setup.toml").write_text(setup)
        trunnion("import", DATA / points / "points.csv", "--setup", at / "setup.toml", "-o", at / "run.mcap")
        return at / "run.mcap"

    added = measured("a", "points-gravity", "SN-1")
    trunnion("add", "gravity-sag:B", added, "--model", added.with_suffix(".model.toml"))
    analysed = measured("b", "points-gravity", None)
    state = json.loads((DATA / "state-removed.json").read_text())
    result = {"run": "run.mcap", "verdict": "missing-effect", "why": "", "missing_effects": ["gravity-sag:B"], "rms_um_before": 9.0, "rms_um_after": 1.0,
              "complete": {"planned": None, "read": 336, "missing": [], "excluded": []}, "report": "run.html"}
    state |= {"removed": None, "answer": {"result": result, "quality": None}}
    analysed.with_suffix(".state.json").write_text(json.dumps(state))
    runs = [added, analysed, measured("c", "points-nothing-hidden", "SN-2"), measured("d", "points-nothing-hidden", "SN-3")]
    for what in ["runs", "parameters"]:
        trunnion("export", "parquet", *runs, "--what", what, "-o", folder / f"{what}.parquet")
    causes, _ = ask(folder)
    check("machines of our own export share a cause", list(causes.effect) == ["gravity-sag:B"], causes)
    check("each by its serial number or its name", list(causes.serials[0]) == ["SN-1", "machine"], list(causes.serials[0]))


def fleet(folder, machines=10_000, months=12):
    """A year of every machine: one in a hundred sags, and the seventh tilts by 2 µrad a day; noise of the stated u."""
    rng = numpy.random.default_rng(1)
    serials = numpy.repeat([f"SN-{k:05}" for k in range(machines)], months)
    day = numpy.tile(numpy.arange(months) * 30, machines)
    began = (pandas.Timestamp("2026-01-01 08:00") + pandas.to_timedelta(day, unit="D")).strftime("%Y-%m-%d %H:%M UTC")
    added, found = (numpy.repeat(numpy.arange(machines) % 200 == odd, months) for odd in (0, 100))
    base = "location-errors ball-setting"
    runs = polars.DataFrame({"machine": "m", "serial": serials, "run": began, "began": began,
                             "effects": numpy.where(added, base + " gravity-sag:B", base),
                             "missing_effects": numpy.where(found, "gravity-sag:B", None).tolist()})
    runs.write_parquet(folder / "runs.parquet")
    parts = []
    for name, unit in [("EA0C", "urad"), ("EB0C", "urad"), ("EX0C", "um"), ("EY0C", "um"), ("EA0B", "urad"), ("EC0B", "urad"), ("EX0B", "um"), ("EZ0B", "um")]:
        value = numpy.repeat(rng.normal(0, 10, machines), months) + rng.normal(0, 0.5, machines * months)
        if name == "EA0B":
            value = value + numpy.where(serials == "SN-00007", 2.0 * day, 0.0)
        parts.append(polars.DataFrame({"machine": "m", "serial": serials, "run": began, "began": began, "effect": "location-errors",
                                       "parameter": name, "value": value, "u": 0.5, "unit": unit, "observable": 1.0}))
    polars.concat(parts).write_parquet(folder / "parameters.parquet")

    begun = time.perf_counter()
    causes, drifts = ask(folder)
    print(f"      {machines * months * 9} rows asked in {time.perf_counter() - begun:.1f} s")
    check("the machines that share a cause", list(causes.effect) == ["gravity-sag:B"] and causes.machines[0] == machines // 100, causes)
    first = drifts.iloc[0]
    found = first.serial == "SN-00007" and first.parameter == "EA0B" and abs(first.per_day - 2.0) < 0.02
    check("the one that drifts is the first", found, first.to_dict())
    # Five of its own uncertainties: of 80 000 lines none by chance, nearly always.
    check("and nearly the only one", len(drifts) <= 3, len(drifts))


with tempfile.TemporaryDirectory() as place:
    read_back(pathlib.Path(place))
    own(pathlib.Path(place) / "own")
    fleet(pathlib.Path(place))
