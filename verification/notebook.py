#!/usr/bin/env python3
"""Run the cells of the notebooks in docs/notebook, each notebook in a Python of its own, and compare what they print.

    notebook.py             closes with `N passed, N failed`, a cell a check
    notebook.py --write     put what the cells print and draw into the notebooks

Jupyter is not needed. Figures are drawn; their pixels are not compared.
"""
from __future__ import annotations

import argparse
import base64
import contextlib
import io
import json
import multiprocessing
import os
import pathlib
import sys
import tempfile
import traceback

TOP = pathlib.Path(__file__).resolve().parents[1]
FOLDER = TOP / "docs" / "notebook"


def run_cell(source: str, names: dict[str, object]) -> list[dict]:
    """Outputs of a cell as a notebook keeps them: its text, then its figures."""
    import matplotlib.pyplot as plt

    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(compile(source, "cell", "exec"), names)
    outputs: list[dict] = []
    if said.getvalue():
        outputs.append({"name": "stdout", "output_type": "stream", "text": said.getvalue().splitlines(keepends=True)})
    for number in plt.get_fignums():
        picture = io.BytesIO()
        plt.figure(number).savefig(picture, format="png", dpi=90, bbox_inches="tight")
        image = base64.b64encode(picture.getvalue()).decode()
        outputs.append({"output_type": "display_data", "metadata": {}, "data": {"image/png": image}})
    plt.close("all")
    return outputs


def kinds_and_text(outputs: list[dict]) -> list[object]:
    """What is compared: text whole, of figures that they are there."""
    return ["".join(o["text"]) if o["output_type"] == "stream" else o["output_type"] for o in outputs]


def run_notebook(path: str, write: bool) -> tuple[int, int]:
    """Cells that print what they should, and those that do not."""
    os.environ["MPLBACKEND"] = "Agg"
    sys.path.insert(0, str(TOP / "tools"))
    book = json.loads(pathlib.Path(path).read_text(encoding="utf-8"))
    passed = failed = 0
    names: dict[str, object] = {"__name__": "__main__"}
    cells = [cell for cell in book["cells"] if cell["cell_type"] == "code"]
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        for number, cell in enumerate(cells, 1):
            try:
                outputs = run_cell("".join(cell["source"]), names)
                trouble = "" if write or kinds_and_text(outputs) == kinds_and_text(cell["outputs"]) else f"it prints {kinds_and_text(outputs)}"
            except Exception:  # a cell that fails is a failed check
                outputs, trouble = [], traceback.format_exc()
            if trouble:
                print(f"FAILED {pathlib.Path(path).name}, cell {number}: {trouble}")
            passed, failed = passed + (not trouble), failed + bool(trouble)
            cell["outputs"], cell["execution_count"] = outputs, number
    if write and not failed:
        pathlib.Path(path).write_text(json.dumps(book, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return passed, failed


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="keep what the cells print and draw")
    words = parser.parse_args()
    with multiprocessing.get_context("spawn").Pool(1, maxtasksperchild=1) as pool:
        results = pool.starmap(run_notebook, [(str(path), words.write) for path in sorted(FOLDER.glob("*.ipynb"))])
    passed, failed = (sum(column) for column in zip(*results)) if results else (0, 1)
    print(f"{passed} passed, {failed} failed")
    return 1 if failed or not passed else 0


if __name__ == "__main__":
    sys.exit(main())
