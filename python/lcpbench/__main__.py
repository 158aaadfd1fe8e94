#!python
"""Starts the program `lcpbench`: `python -m lcpbench`, and the command `lcpbench` of a wheel, which has it inside."""

import importlib.util
import os
import shutil
import sys


def main() -> None:
    """Becomes the program. Its helpers in Python (`python3 -m lcpbench...`) are then this Python's."""
    folder = importlib.util.find_spec("lcpbench").submodule_search_locations[0]  # which does not import the package
    program = os.path.join(folder, "bin", "lcpbench")
    if not os.path.exists(program):
        program = os.environ.get("LCPBENCH_PROGRAM") or shutil.which("lcpbench") or ""
    if not program:
        sys.exit("lcpbench: this package was built without the program: install a wheel, or build the source by ./run-study "
                 "and name build/release/lcpbench in LCPBENCH_PROGRAM")
    os.environ["PATH"] = os.path.dirname(sys.executable) + os.pathsep + os.environ.get("PATH", os.defpath)
    try:
        os.execv(program, ["lcpbench", *sys.argv[1:]])
    except OSError as error:
        sys.exit(f"lcpbench: {program}: {error.strerror}")


if __name__ == "__main__":
    main()
