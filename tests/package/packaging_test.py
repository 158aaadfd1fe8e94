"""Checks what no build reads: packaging_test.py workflows|recipe|site SOURCE. Ends with 77 where a tool is missing."""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

WHAT, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
TOOLS = SOURCE / "build/nanobind/bin"  # where ./run-tests puts what comes from PyPI
ADDRESSES = r"https://[\w.]*OWNER[\w./]*"


def run(*command):
    done = subprocess.run(command, cwd=SOURCE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    print(done.stdout)
    if done.returncode != 0:
        sys.exit(f"exit code {done.returncode} of {' '.join(map(str, command))}")


def tool(name):
    return shutil.which(name) or shutil.which(name, path=str(TOOLS))


def skip(reason):
    print("SKIPPED:", reason)
    sys.exit(77)


def workflows():
    """Files that are named exist; addresses are those of the citation; actionlint finds nothing."""
    files = [*sorted((SOURCE / ".github/workflows").glob("*.yml")), SOURCE / "pyproject.toml", SOURCE / "python/wheels.Dockerfile",
             SOURCE / "python/wheels.sh", SOURCE / "python/release.sh"]
    cited = set(re.findall(ADDRESSES, (SOURCE / "CITATION.cff").read_text()))
    for file in [*files, SOURCE / "mkdocs.yml", SOURCE / "python/conda/recipe.yaml"]:
        text = file.read_text()
        for path in re.findall(r"(?<![\w/.-])(?:(?:\./|\{project\}/)?(?:python|cmake|docs)/[\w./-]+\.\w+|\./run-\w+)", text):
            assert (SOURCE / path.replace("{project}/", "")).exists(), f"{file.name}: {path} does not exist"
        for address in re.findall(ADDRESSES, text):
            assert address.removesuffix("/issues") in cited, f"{file.name}: {address} is not in CITATION.cff"
    if tool("actionlint") is None:
        skip("actionlint is not in PATH: the syntax of the workflows is not checked")
    run(tool("actionlint"), *files[:-4])


def recipe():
    """rattler-build reads and renders the recipe."""
    program = ("import rattler_build, sys\n"
               "recipe = rattler_build.Stage0Recipe.from_yaml(open('python/conda/recipe.yaml').read())\n"
               "print([each.recipe.package.version for each in recipe.render(rattler_build.VariantConfig({'c_stdlib': ['sysroot']}))])")
    python = TOOLS / "python" if TOOLS.exists() else sys.executable
    if subprocess.run([python, "-c", "import rattler_build"], capture_output=True).returncode != 0:
        skip("needs py-rattler-build from PyPI")
    run(python, "-c", program)


def site():
    """The site is built, and each of its links leads somewhere."""
    if tool("mkdocs") is None:
        skip("needs mkdocs-material from PyPI, which ./run-tests installs")
    with tempfile.TemporaryDirectory() as folder:
        run(tool("mkdocs"), "build", "--strict", "--quiet", "--site-dir", folder)
        words = (pathlib.Path(folder) / "search/search_index.json").read_text()
        assert "contact_lemke" in words, "the search finds nothing"


{"workflows": workflows, "recipe": recipe, "site": site}[WHAT]()
