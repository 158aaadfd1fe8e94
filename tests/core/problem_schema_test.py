"""The published JSON schemas accept every kind of file that is written, and the examples. They and the reader refuse
bad ones.

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
    mixed = good["mixed"]
    for field in ("friction_of", "mu"):
        yield f"mixed lcp without {field}", deleted(mixed, field)
    yield "bound of text", changed(mixed, ["0", None], "lower")
    yield "friction of half a row", changed(mixed, [None, 0.5], "friction_of")
    yield "friction of row -2", changed(mixed, [None, -2], "friction_of")
    for field in ("v", "N", "D", "edges", "mu", "G"):
        yield f"contact without {field}", deleted(frictional, field)
    rows = good["rows"]
    for field in ("R", "lower", "upper", "friction_of", "mu"):
        yield f"rows without {field}", deleted(rows, "rows", field)
    yield "rows of scenes", changed(scene, rows["rows"], "rows")
    yield "unknown field of rows", changed(rows, 1, "rows", "extra")
    yield "lower bound above 0", changed(rows, 1, "rows", "lower", 0)
    yield "upper bound below 0", changed(rows, -1, "rows", "upper", 0)
    yield "negative compliance of rows", changed(rows, -1, "rows", "compliance", 0)
    yield "unknown unit", changed(rows, "deg", "rows", "unit", 0)
    yield "names of numbers", changed(rows, 1, "rows", "names", 0)
    yield "control character in a row's name", changed(rows, "a\nb", "rows", "names", 0)
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
    yield "G and G_blocks", changed(frictional, [[[1]]], "G_blocks")
    yield "blocks of numbers", changed(deleted(frictional, "G"), [[1]], "G_blocks")
    sparse = changed(frictional, {"starts": [0, 1], "rows": [0], "values": [1]}, "N")
    for field in ("starts", "rows", "values"):
        yield f"sparse N without {field}", deleted(sparse, "N", field)
    yield "negative row", changed(sparse, [-1], "N", "rows")
    yield "alpha of zero", changed(factored, [0], "G_factors", "alpha")
    yield "mass of zero", changed(scene, 0, "bodies", 0, "mass")
    yield "inertia 2 x 3", deleted(scene, "bodies", 0, "inertia", 0)
    yield "position of two", deleted(scene, "bodies", 0, "position", 0)
    yield "body_a is the world", changed(scene, -1, "contacts", 0, "body_a")
    yield "six edges", changed(scene, 6, "contacts", 0, "edges")
    yield "negative mu in a scene", changed(scene, -1, "contacts", 0, "mu")
    yield "tangent without edges", changed(scene, [1, 0, 0], "contacts", 1, "tangent")
    yield "mu without edges", changed(scene, 0.5, "contacts", 1, "mu")


def bad_lines(header, step):
    """Pairs of what is wrong and a line of a scenes file with it."""
    for field in ("format", "version", "scene"):
        yield f"header without {field}", deleted(header, field)
    for field in ("step", "problem"):
        yield f"step without {field}", deleted(step, field)
    yield "version 2", changed(header, 2, "version")
    yield "shape without type", changed(header, [{"body": 0, "size": []}], "shapes")
    yield "unknown field", changed(step, 1, "extra")
    yield "negative step", changed(step, -1, "step")
    yield "bad problem", changed(step, 0, "problem", "version")
    yield "bare LCP", changed(step, {"format": "lcpbench-problem", "version": 1, "name": "n", "kind": "lcp", "M": [], "q": []}, "problem")
    yield "pose of two", changed(step, [[1, 2]], "poses")
    yield "ids of numbers", changed(step, [1], "contact_ids")


def lines_validator(schema_file, problem):
    """Of scenes.schema.json, which refers to the problem's schema, with that in place."""
    text = pathlib.Path(schema_file).with_name("scenes.schema.json").read_text(encoding="utf-8")
    text = text.replace('"problem.schema.json#/definitions/', '"#/definitions/')
    schema = json.loads(text.replace('"problem.schema.json#"', '"#/definitions/problem"'))
    schema["definitions"] = {**schema["definitions"], **problem["definitions"], "problem": deleted(problem, "definitions")}
    jsonschema.Draft7Validator.check_schema(schema)
    return jsonschema.Draft7Validator(schema)


def check_scenes(validator, file, failures):
    lines = [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]
    for number, line in enumerate(lines, 1):
        failures += [f"{file.name}, line {number}, is refused: {error.message[:200]}" for error in validator.iter_errors(line)]
    failures += [f"accepted: {what}" for what, line in bad_lines(lines[0], lines[1]) if validator.is_valid(line)]
    return len(lines)


def read_of(writer, documents):
    """The names of those that the program reads."""
    with tempfile.TemporaryDirectory() as folder:
        for what, document in documents.items():
            (pathlib.Path(folder) / f"{what}.json").write_text(json.dumps(document), encoding="utf-8")
        return subprocess.run([writer, "--read", folder], capture_output=True, text=True, check=True).stdout.splitlines()


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
        lines = check_scenes(lines_validator(schema_file, schema), pathlib.Path(folder) / "steps.scenes", failures)
    bad = dict(bad_documents(good))
    failures += [f"accepted: {what}" for what, document in bad.items() if validator.is_valid(document)]
    failures += [f"read: {what}" for what in read_of(writer, bad)]
    failures += [f"not read: {what}" for what in set(good) - set(read_of(writer, good))]
    print(f"{len(good)} good files, {lines} lines of scenes, {len(bad)} bad documents")
    print("\n".join(failures))
    return 1 if failures or not good else 0


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
