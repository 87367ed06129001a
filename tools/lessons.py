"""Remove from the lessons what Jupyter stores in them: `python tools/lessons.py`.

Outputs are recreated wherever a lesson is opened or built, and counts and versions are irrelevant.  The rest is written
in Jupyter's format, so saving a lesson does not change lines that have not been edited.
"""

import json
from pathlib import Path

LESSONS = Path(__file__).parents[1] / "docs/lessons"
KERNEL = {"display_name": "Python 3", "language": "python", "name": "python3"}
KEPT = ("jupyter", "mystnb", "tags")  # whether a cell is folded: in Jupyter, on the pages


def clean(text):
    """Return a notebook without outputs, counts and versions."""
    book = json.loads(text)
    cells = []
    for cell in book["cells"]:
        kept = {key: cell[key] for key in ("cell_type", "id", "source")}
        kept["metadata"] = {key: cell["metadata"][key] for key in KEPT if key in cell["metadata"]}
        if cell["cell_type"] == "code":
            kept |= {"execution_count": None, "outputs": []}
        cells.append(kept)
    metadata = {"kernelspec": KERNEL, "language_info": {"name": "python"}}
    cleaned = {"cells": cells, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(cleaned, indent=1, ensure_ascii=False, sort_keys=True) + "\n"


if __name__ == "__main__":
    for path in sorted(LESSONS.glob("*.ipynb")):
        path.write_text(clean(path.read_text("utf-8")), "utf-8")
