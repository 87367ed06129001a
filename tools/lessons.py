"""Clean the lessons of what Jupyter leaves in them: `python tools/lessons.py`; with `--check`, only say which need it.

Outputs are made again wherever a lesson is opened or built, and counts and the version of somebody's Python are noise in
a comparison of two versions.  What remains is written as Jupyter writes it, so that saving a lesson changes no line that
nobody has edited.
"""

import json
import sys
from pathlib import Path

LESSONS = Path(__file__).parents[1] / "docs/lessons"
KERNEL = {"display_name": "Python 3", "language": "python", "name": "python3"}
KEPT = ("jupyter", "tags")  # of what a cell says about itself: whether it is folded, in Jupyter and in the docs


def clean(text):
    """A notebook without outputs, counts and versions."""
    book = json.loads(text)
    cells = []
    for cell in book["cells"]:
        about = {key: cell["metadata"][key] for key in KEPT if key in cell["metadata"]}
        kept = {key: cell[key] for key in ("cell_type", "id", "source")} | {"metadata": about}
        if cell["cell_type"] == "code":
            kept |= {"execution_count": None, "outputs": []}
        cells.append(kept)
    metadata = {"kernelspec": KERNEL, "language_info": {"name": "python"}}
    cleaned = {"cells": cells, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(cleaned, indent=1, ensure_ascii=False, sort_keys=True) + "\n"


def main(check):
    dirty = [path for path in sorted(LESSONS.glob("*.ipynb")) if clean(path.read_text("utf-8")) != path.read_text("utf-8")]
    for path in dirty:
        print(path.relative_to(LESSONS.parents[1]), "holds outputs or counts" if check else "is clean now")
        if not check:
            path.write_text(clean(path.read_text("utf-8")), "utf-8")
    if check and dirty:
        sys.exit("run python tools/lessons.py")


if __name__ == "__main__":
    main("--check" in sys.argv[1:])
