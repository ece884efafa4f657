#!/usr/bin/env python3
"""The Python package in a clean environment against the command line: `python_wheel.py TRUNNION WHEEL`.

Makes a virtual environment of its own, installs the wheel with pandas and mypy, and runs itself there. Every figure of the package is
compared with the JSON or the table that the program prints; the five lines of docs/use/python.md run as they stand; the type stubs are
compared with the package by mypy's own tool. Every check prints a line; the first that fails ends it.
"""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import threading
import venv

from checks import check, trunnion as command

ROOT = pathlib.Path(__file__).resolve().parents[2]
GUIDE = ROOT / "docs/use/python.md"
NEEDS = ["--constraint", ROOT / "tests/peers/requirements.txt", "pandas", "pandas-stubs", "mypy"]


def main(program, wheel):
    with tempfile.TemporaryDirectory() as place:
        clean = pathlib.Path(place) / "venv"
        venv.create(clean, with_pip=True)
        python = clean / "bin/python"
        subprocess.run([python, "-m", "pip", "install", "--quiet", wheel], check=True)
        without = subprocess.run([python, "-c", "import trunnion; print(trunnion.open(*__import__('sys').argv[1:]).points())",
                                  ROOT / "tests/data/points-gravity/points.csv"], capture_output=True, text=True)
        check("without pandas a table says what it needs", "ImportError: tables need pandas" in without.stderr, without.stderr)
        subprocess.run([python, "-m", "pip", "install", "--quiet", *NEEDS], check=True)
        types(python, pathlib.Path(place))
        # The tests work in a folder of their own.
        program = pathlib.Path(program).resolve()
        sys.exit(subprocess.run([python, __file__, program, "--inside", place]).returncode)


def types(python, place):
    """The stubs are those of the package, and the five lines pass the strict checker."""
    stubs = subprocess.run([python, "-m", "mypy.stubtest", "trunnion", "--ignore-missing-stub"], capture_output=True, text=True, cwd=place)
    check("the type stubs are those of the package", stubs.returncode == 0, stubs.stdout + stubs.stderr)
    (place / "five.py").write_text(five_lines())
    strict = subprocess.run([python, "-m", "mypy", "--strict", "five.py"], capture_output=True, text=True, cwd=place)
    check("the five lines are well typed", strict.returncode == 0, strict.stdout + strict.stderr)


def five_lines():
    (lines,) = re.findall(r"```python\n(.*?)```", GUIDE.read_text(), re.S)
    check("they are five lines", len(lines.splitlines()) == 5, lines)
    return lines


def inside(place):
    os.chdir(place)
    for run, name in [("run", "points-gravity"), ("other", "points-nothing-hidden")]:
        points = ROOT / "tests/data" / name
        command("import", points / "points.csv", "--setup", points / "setup.toml", "-o", f"{run}.mcap")
    figures()
    tables()
    errors()
    threads()
    notebook()
    documented()


def figures():
    import trunnion

    run, other = trunnion.open("run.mcap"), trunnion.open(pathlib.Path("other.mcap"))
    fit = run.fit()
    found = fit.diagnose()
    step = found.add(by="a tester")
    check("open reads machine and runs", (run.machine, run.runs) == ("table-bc", ["run"]), (run.machine, run.runs))
    same("check", run.check(), "check", "run.mcap")
    same("fit", fit.results(), "identify", "run.mcap")
    same("diagnose", found.results(), "diagnose", "run.mcap")
    check("the verdict is that of the answer", found.verdict == found.results()["verdict"] == "missing-effect", found.verdict)
    check("the leading effect is added", step.effect == found.best == "gravity-sag:B", step.effect)
    command("add", found.best, "run.mcap", "--model", "by-command.toml", "--by", "a tester")
    check("the model file is that of the command line", step.model.text == pathlib.Path("by-command.toml").read_text())
    step.model.save("model.toml")
    same("the ladder", step.model.results(), "ladder", "--model", "model.toml")
    same("predict", step.predict(other).results() | {"fitted_on": ""}, "predict", "other.mcap", "--fitted", "run.mcap", "--model", "model.toml")
    loaded = trunnion.Model.load("model.toml")
    same("predict with kept values", loaded.predict(other).results(), "predict", "other.mcap", "--model", "model.toml")
    same("fit of a model", run.fit(loaded).results(), "identify", "run.mcap", "--model", "model.toml")
    check("the effects are those of the file", loaded.effects == ["location-errors", "ball-setting", "gravity-sag:B"], loaded.effects)
    check("text is that of the command line", unfolded(found.summary()) == unfolded(command("diagnose", "run.mcap")))
    check("print shows it", str(found) == found.summary() and "gravity-sag:B" in repr(found), repr(found))
    both = trunnion.open("run.mcap", "other.mcap").fit()
    same("two runs together", both.results(), "identify", "run.mcap", "other.mcap")


def unfolded(text):
    """The command folds its lines, at hyphens too."""
    return "".join(text.split())


def same(what, ours, *arguments):
    theirs = json.loads(command(*arguments, "--json"))
    unlike = [key for key in {**ours, **theirs} if ours.get(key) != theirs.get(key)]
    check(f"{what}: every figure is that of the command line", not unlike and len(ours) > 2, unlike)


def tables():
    import io

    import pandas

    import trunnion

    run = trunnion.open("run.mcap")
    fit = run.fit()
    tables = {"points": run.points().drop(columns="run"), "parameters": fit.parameters(), "residuals": fit.residuals()}
    for what, table in tables.items():
        exported = pandas.read_csv(io.StringIO(command("export", "csv", "run.mcap", "--what", what)))
        check(f"the table of {what} is that of export", table.equals(exported), f"{len(table)} rows")
    values = {row["name"]: row["value"] for row in fit.results()["parameters"]}
    read = {row.parameter: None if pandas.isna(row.value) else row.value for row in fit.parameters().itertuples()}
    check("and its parameters those of the answer, to the last bit", read == values)
    found = fit.diagnose()
    check("candidates are listed, best first", found.candidates()["effect"].iloc[0] == found.best, list(found.candidates().columns))
    ladder = found.add().ladder()
    falls = ladder["error_after_um"].iloc[0] < 0.5 * ladder["error_before_um"].iloc[0]
    check("the error falls by half in the ladder", list(ladder["effect"]) == ["gravity-sag:B"] and falls, ladder.to_dict("records"))
    predicted = fit.predict(run)
    check("each predicted run is a row", list(predicted.runs()["rms_um"]) == [one["rms_um"] for one in predicted.results()["runs"]])


def errors():
    import warnings

    import trunnion

    def sentence(work):
        try:
            work()
        except trunnion.Error as error:
            return str(error)
        return "no error"

    asked = subprocess.run([sys.argv[1], "identify", "nowhere.mcap"], capture_output=True, text=True).stderr
    found = sentence(lambda: trunnion.open("nowhere.mcap"))
    check("an error is the sentence of the command line", found and unfolded(found) in unfolded(asked), found)
    fit = trunnion.open("run.mcap").fit()
    check("an unknown effect is named", "gravity-sog:B" in sentence(lambda: fit.add("gravity-sog:B")), sentence(lambda: fit.add("gravity-sog:B")))
    check("nothing is added where nothing is named", "names no effect" in sentence(lambda: fit.add("gravity-sag:B").diagnose().add()))
    check("no run is an error", sentence(lambda: trunnion.open()) != "no error", sentence(lambda: trunnion.open()))
    pathlib.Path("cut.mcap").write_bytes(pathlib.Path("run.mcap").read_bytes()[:-200])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        damage = trunnion.open("cut.mcap").damage
    check("a damaged recording is a warning", damage and [str(one.message) for one in caught] == damage, damage)


def threads():
    """A thread counts while a diagnosis computes: with the interpreter's lock held it could not."""
    import trunnion

    fit = trunnion.open("run.mcap").fit()
    counted, done = 0, threading.Event()
    work = threading.Thread(target=lambda: (fit.diagnose(), done.set()))
    work.start()
    # Each wait gives the lock back; it comes in time only where nobody else keeps it.
    while not done.wait(0.001):
        counted += 1
    work.join()
    check("other threads go on while it computes", counted >= 10, f"{counted} rounds")


def notebook():
    shown = {}
    *lines, last = five_lines().splitlines()
    exec("\n".join(lines), shown)
    ladder = eval(last.split("#")[0], shown)
    check("the five lines of the guide run", list(ladder["effect"]) == ["gravity-sag:B"])


def documented():
    import inspect

    import trunnion

    bare = [name for name in trunnion.__all__ if name != "__version__" and not inspect.getdoc(getattr(trunnion, name))]
    for kind in (getattr(trunnion, name) for name in trunnion.__all__ if inspect.isclass(getattr(trunnion, name))):
        own = [name for name in vars(kind) if not name.startswith("_")]
        bare += [f"{kind.__name__}.{name}" for name in own if not inspect.getdoc(getattr(kind, name))]
    check("everything has a docstring", not bare, bare)
    version = command("--version").split()[-1]
    check("one version", trunnion.__version__ == version, (trunnion.__version__, version))


if "--inside" in sys.argv:
    inside(sys.argv[3])
else:
    main(*sys.argv[1:])
