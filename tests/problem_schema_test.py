"""The published JSON schema accepts every kind of file that is written, and the examples, and refuses bad ones.

usage: problem_schema_test.py SCHEMA EXAMPLES WRITER     (WRITER FOLDER writes one file of every kind)
"""

import copy
import json
import pathlib
import subprocess
import sys
import tempfile

try:
    import jsonschema
except ImportError:
    sys.exit("this test needs the Python package jsonschema: install python3-jsonschema")


def deleted(document, *path):
    result = copy.deepcopy(document)
    inner = result
    for key in path[:-1]:
        inner = inner[key]
    del inner[path[-1]]
    return result


def changed(document, value, *path):
    result = copy.deepcopy(document)
    inner = result
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    return result


def bad_documents(good):
    """Pairs of what is wrong and a document with it."""
    lcp, frictional, factored, scene = good["lcp"], good["frictional"], good["factored"], good["scene"]
    for field in ("format", "version", "name", "kind", "M", "q"):
        yield f"lcp without {field}", deleted(lcp, field)
    for field in ("v", "N", "D", "edges", "mu", "G"):
        yield f"contact without {field}", deleted(frictional, field)
    for field in ("mass", "inertia", "position", "linear_velocity", "angular_velocity"):
        yield f"body without {field}", deleted(scene, "bodies", 0, field)
    for field in ("body_a", "body_b", "point", "normal", "tangent", "mu", "edges"):
        yield f"contact without {field}", deleted(scene, "contacts", 0, field)
    for field in ("bodies", "contacts"):
        yield f"scene without {field}", deleted(scene, field)
    for field in ("X", "alpha"):
        yield f"factors without {field}", deleted(factored, "G_factors", field)
    yield "no object", [1]
    yield "other format", changed(lcp, "other", "format")
    yield "version 2", changed(lcp, 2, "version")
    yield "empty name", changed(lcp, "", "name")
    yield "control character in the name", changed(lcp, "a\nb", "name")
    yield "unknown kind", changed(lcp, "qp", "kind")
    yield "unknown field", changed(lcp, 1, "extra")
    yield "field of another kind", changed(lcp, [1], "v")
    yield "kind of another file", changed(lcp, "contact", "kind")
    yield "M is a vector", changed(lcp, [1, 2], "M")
    yield "null for a number", changed(lcp, [1, None], "q")
    yield "text for a number", changed(lcp, [1, "2"], "q")
    yield "odd edges", changed(frictional, [3], "edges")
    yield "negative edges", changed(frictional, [-2], "edges")
    yield "negative mu", changed(frictional, [-0.5], "mu")
    yield "G and Ginv", changed(frictional, [[1]], "Ginv")
    yield "G and G_factors", changed(factored, [[1]], "G")
    yield "alpha of zero", changed(factored, [0], "G_factors", "alpha")
    yield "mass of zero", changed(scene, 0, "bodies", 0, "mass")
    yield "inertia 2 x 3", deleted(scene, "bodies", 0, "inertia", 0)
    yield "position of two", deleted(scene, "bodies", 0, "position", 0)
    yield "body_a is the world", changed(scene, -1, "contacts", 0, "body_a")
    yield "six edges", changed(scene, 6, "contacts", 0, "edges")
    yield "negative mu in a scene", changed(scene, -1, "contacts", 0, "mu")
    yield "tangent without edges", changed(scene, [1, 0, 0], "contacts", 1, "tangent")
    yield "mu without edges", changed(scene, 0.5, "contacts", 1, "mu")


def main(schema_file, examples, writer):
    schema = json.loads(pathlib.Path(schema_file).read_text(encoding="utf-8"))
    jsonschema.Draft7Validator.check_schema(schema)
    validator = jsonschema.Draft7Validator(schema)
    failures = []
    good = {}
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([writer, folder], check=True)
        files = sorted(pathlib.Path(folder).glob("*.json")) + sorted(pathlib.Path(examples).glob("*.json"))
        for file in files:
            good[file.stem] = json.loads(file.read_text(encoding="utf-8"))
            failures += [f"{file.name} is refused: {error.message[:200]}" for error in validator.iter_errors(good[file.stem])]
    refused = 0
    for what, document in bad_documents(good):
        if validator.is_valid(document):
            failures.append(f"accepted: {what}")
        refused += 1
    print(f"{len(good)} good files, {refused} bad documents")
    print("\n".join(failures))
    return 1 if failures or not good else 0


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
