"""Checks what no build reads: packaging_test.py workflows|recipe|site SOURCE. Ends with 77 where a tool is missing."""

import functools
import http.server
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import threading

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
        skip("the syntax of the workflows is not checked without actionlint, which ./run-tests installs where Go is")
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
    """The site is built, each of its links leads somewhere, and its search finds a solver's page."""
    if tool("mkdocs") is None:
        skip("needs mkdocs-material from PyPI, which ./run-tests installs")
    sys.path.insert(0, str(SOURCE / "tests/support"))
    import chromium
    with tempfile.TemporaryDirectory() as folder:
        run(tool("mkdocs"), "build", "--strict", "--quiet", "--site-dir", folder)
        if not chromium.find_chromium():
            skip("Chromium is not installed: the search is not tried")
        handler = functools.partial(http.server.SimpleHTTPRequestHandler, directory=folder)
        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server, chromium.Browser() as browser:
            threading.Thread(target=server.serve_forever, daemon=True).start()
            browser.open(f"http://127.0.0.1:{server.server_port}/?q=contact_lemke")
            browser.wait("document.querySelector('.md-search-result__item a')", 30)
            found = browser.run("document.querySelector('.md-search-result__item a').pathname")
            server.shutdown()
        assert found == "/reference/solvers/contact_lemke/", f"the search finds {found} first"


{"workflows": workflows, "recipe": recipe, "site": site}[WHAT]()
