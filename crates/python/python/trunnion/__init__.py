"""Finds out why a five-axis machine tool is not accurate: recordings in, the missing physical effect out.

    import trunnion
    run = trunnion.open("run.mcap")
    found = run.fit().diagnose()
    print(found)
    found.add().ladder()

Answers have `results()`, the JSON of the command line as dictionaries, `summary()`, the same as text, and tables for pandas.
"""

from ._trunnion import (
    Diagnosed,
    Error,
    Experiment,
    Fit,
    Model,
    Prediction,
    Step,
    __version__,
    open,
)

__all__ = ["Diagnosed", "Error", "Experiment", "Fit", "Model", "Prediction", "Step", "__version__", "open"]
