"""What the scripts over the real program share: a check prints a line, and the first that fails ends the script."""

import subprocess
import sys

TRUNNION = sys.argv[1]


def check(what, good, found=""):
    print(("ok    " if good else "FAILED ") + what, found, flush=True)
    if not good:
        sys.exit(1)


def trunnion(*arguments, code=None):
    """What a command prints; `code`: how it has to end, done or done with a loss where not given."""
    done = subprocess.run([TRUNNION, *map(str, arguments)], capture_output=True, text=True)
    check(f"trunnion {arguments[0]} runs", done.returncode in ((0, 3) if code is None else (code,)), done.stderr)
    return done.stdout
