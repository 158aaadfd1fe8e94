"""The published schema of views accepts what `lcpbench view` prints of each kind of scene, and refuses other numbers.

usage: view_schema_test.py PROGRAM SOURCE
"""

import json
import pathlib
import re
import subprocess
import sys

try:
    import jsonschema
except ImportError:
    sys.exit("this test needs the Python package jsonschema: install python3-jsonschema")

program, source = sys.argv[1], pathlib.Path(sys.argv[2])
checker = jsonschema.Draft7Validator(json.loads((source / "docs/schema/view.schema.json").read_text()))
shown = [source / "examples/box_on_slope.json"]
for scene in ("stack/ode", "hand/mujoco", "closed-chain/mujoco", "sphere-pile/dart"):
    file = source / "generators/scenes" / f"{scene}.scenes"
    answer = subprocess.run([program, "view", file], capture_output=True, text=True).stderr
    shown.append(re.search(r"name one, as '(.*)'", answer)[1])
for file in shown:
    text = subprocess.run([program, "view", file, "--format", "json"], capture_output=True, text=True, check=True).stdout
    view = json.loads(text)["scenes"][0]
    checker.validate(view)
    view["contacts"]["mu"] = "0.5"
    if checker.is_valid(view):
        sys.exit(f"{file}: the schema takes a text for numbers")
print(f"{len(shown)} views fit the schema")
