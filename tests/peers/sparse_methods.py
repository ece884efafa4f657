"""Sparse regression as its users run it, on the trials that `blind-trial --export FOLDER` wrote.

    python sparse_methods.py FOLDER [--check]

PySINDy's STLSQ with its threshold chosen by BIC, and scikit-learn's OrthogonalMatchingPursuitCV, get the columns of every effect of
the catalogue and the readings, the base model projected out of both. An effect counts as named when one of its columns is.
Prints a markdown table with our own answers beside. --check: fails unless there are trials with nothing hidden and both methods claim
something in most of them.
"""

import argparse
import json
import os
import sys
import warnings
from collections import defaultdict
from pathlib import Path

# Matrices this small are slower on many threads; to be said before NumPy is loaded.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np
from pysindy.optimizers import STLSQ
from sklearn.linear_model import OrthogonalMatchingPursuitCV

# Of unit columns, in µm of reading: from keeping nearly all columns to keeping none.
THRESHOLDS_UM = np.geomspace(0.01, 0.4, 24)
LARGEST_MODEL = 25
FOLDS = 5


def unit_columns(columns):
    """Columns scaled to 1 µm rms, so that one threshold means the same for all."""
    return columns / np.sqrt((columns**2).mean(axis=0))


def bic(columns, readings, chosen):
    """n ln(RSS/n) + k ln n after least squares on the chosen columns."""
    rows = len(readings)
    left = readings
    if chosen.any():
        part = columns[:, chosen]
        left = readings - part @ np.linalg.lstsq(part, readings, rcond=None)[0]
    return rows * np.log(left @ left / rows) + chosen.sum() * np.log(rows)


def stlsq(columns, readings):
    """Columns kept by sequentially thresholded least squares at the threshold with the best BIC."""
    nothing = np.zeros(columns.shape[1], dtype=bool)
    best = (bic(columns, readings, nothing), nothing)
    for threshold in THRESHOLDS_UM:
        optimizer = STLSQ(threshold=threshold)
        optimizer.fit(columns, readings.reshape(-1, 1))
        chosen = optimizer.coef_.ravel() != 0.0
        best = min(best, (bic(columns, readings, chosen), chosen), key=lambda pair: pair[0])
    return best[1]


def omp(columns, readings):
    """Columns kept by orthogonal matching pursuit, their number by cross-validation."""
    largest = min(LARGEST_MODEL, columns.shape[1])
    fit = OrthogonalMatchingPursuitCV(cv=FOLDS, max_iter=largest, fit_intercept=False).fit(columns, readings)
    return fit.coef_ != 0.0


METHODS = {"PySINDy STLSQ, threshold by BIC": stlsq, "scikit-learn OMP, cross-validated": omp}
OURS = "trunnion"


def named(method, columns, readings, effect_of_column):
    with warnings.catch_warnings():
        # Both warn of dependent columns, which this catalogue has, and of empty models.
        warnings.simplefilter("ignore")
        chosen = method(columns, readings)
    return {effect for effect, is_chosen in zip(effect_of_column, chosen) if is_chosen}


def share(count, runs):
    return f"{count} of {runs} ({100 * count / runs:.0f} %)" if runs else "–"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()
    trials = sorted(arguments.folder.glob("*/trial.json"))
    if not trials:
        sys.exit(f"no trial in {arguments.folder}; write some with: blind-trial --export {arguments.folder}")

    # (method, noise) -> number of effects named in each run with nothing hidden; exact or not in each with one.
    null, single = defaultdict(list), defaultdict(list)
    noises = []
    for path in trials:
        trial = json.loads(path.read_text())
        if trial["group"] not in ("null", "single"):
            continue
        columns = unit_columns(np.load(path.parent / "columns.npy").astype(float))
        readings = np.load(path.parent / "readings.npy").astype(float).ravel()
        answers = {
            name: named(method, columns, readings, trial["effect_of_column"]) for name, method in METHODS.items()
        }
        answers[OURS] = set(trial["found"])
        noise = trial["noise"]
        if noise not in noises:
            noises.append(noise)
        for name, effects in answers.items():
            if trial["group"] == "null":
                null[name, noise].append(len(effects))
            else:
                single[name, noise].append(effects == set(trial["hidden"]))

    print("| method | noise | nothing hidden: claims something | false effects each | one hidden: exactly that set |")
    print("| --- | --- | --- | --- | --- |")
    for noise in noises:
        for name in [*METHODS, OURS]:
            counts, exact = null[name, noise], single[name, noise]
            claims = share(sum(count > 0 for count in counts), len(counts))
            each = f"{np.mean(counts):.1f}" if counts else "–"
            print(f"| {name} | {noise} | {claims} | {each} | {share(sum(exact), len(exact))} |")

    if arguments.check:
        for name in METHODS:
            counts = [count for noise in noises for count in null[name, noise]]
            if not counts or 2 * sum(count > 0 for count in counts) <= len(counts):
                sys.exit(f"{name} claims something in {sum(c > 0 for c in counts)} of {len(counts)} runs with nothing hidden")


if __name__ == "__main__":
    main()
