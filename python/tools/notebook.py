#!/usr/bin/env python3
"""notebook.py PAGE.md > NAME.ipynb: prints a page as a notebook. Its ```python blocks are cells, and a ```text block
that follows one is its output."""
import json
import pathlib
import re
import sys


def notebook(page):
    cells = []
    parts = re.split(r"^```python\n(.*?)^```\n(?:\n?```text\n(.*?)^```\n)?", page, flags=re.S | re.M)
    for k in range(0, len(parts), 3):
        if text := parts[k].strip():
            cells.append({"cell_type": "markdown", "metadata": {}, "source": text})
        if k + 1 < len(parts):
            output = [{"output_type": "stream", "name": "stdout", "text": parts[k + 2]}] if parts[k + 2] else []
            cells.append({"cell_type": "code", "metadata": {}, "execution_count": None, "outputs": output,
                          "source": parts[k + 1].strip()})
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    return {"cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 4}


if __name__ == "__main__":
    print(json.dumps(notebook(pathlib.Path(sys.argv[1]).read_text()), indent=1))
