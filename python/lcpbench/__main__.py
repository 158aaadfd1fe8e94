#!python
"""Starts the program `lcpbench` that a wheel has inside: `python -m lcpbench`, and the command `lcpbench` itself."""

import importlib.util
import os
import sys


def main() -> None:
    """Becomes the program. Its helpers in Python (`python3 -m lcpbench...`) are then this Python's."""
    folder = importlib.util.find_spec("lcpbench").submodule_search_locations[0]  # which does not import the package
    program = os.path.join(folder, "bin", "lcpbench")
    if not os.path.exists(program):
        sys.exit("lcpbench: this package was built without the program; wheels have it, and so have builds of the source")
    os.environ["PATH"] = os.path.dirname(sys.executable) + os.pathsep + os.environ.get("PATH", os.defpath)
    os.execv(program, ["lcpbench", *sys.argv[1:]])


if __name__ == "__main__":
    main()
