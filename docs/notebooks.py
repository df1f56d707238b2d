"""The notebooks of examples/, executed: `python docs/notebooks.py` writes them anew, small and the same on any machine.

A cell with the tag `scene` shows a page of some megabytes; its output is made when the notebook runs, and not kept.
"""

from __future__ import annotations

import argparse
import os
import re
import tempfile
from pathlib import Path

import nbformat
from nbclient import NotebookClient

ROOT = Path(__file__).resolve().parent.parent
NOTEBOOKS = sorted((ROOT / "examples").glob("*.ipynb"))
_PATH = re.compile(r"(?:/[\w.+-]+)+/(?=[\w.-]+)")
_SECONDS = re.compile(r"(?<=, )[\d.]+ s(?=\))")


def executed(path: Path) -> nbformat.NotebookNode:
    """A notebook after all its cells ran, in a folder of their own; the first cell that fails raises."""
    notebook = nbformat.read(path, as_version=4)
    inline = "module://matplotlib_inline.backend_inline"  # whatever the surrounding process draws with
    env = {**os.environ, "PYTHONPATH": str(ROOT), "MPLBACKEND": inline}
    with tempfile.TemporaryDirectory() as folder:
        client = NotebookClient(notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": folder}})
        client.execute(env=env)
    return notebook


def kept(notebook: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """The same without what differs from run to run, and without its scenes."""
    notebook.metadata = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    for number, cell in enumerate(notebook.cells):
        cell.id = f"cell-{number}"
        if cell.cell_type != "code":
            continue
        cell.metadata = {"tags": cell.metadata.get("tags", [])}
        cell.execution_count = None
        scene = "scene" in cell.metadata["tags"]
        cell.outputs = [] if scene else [_plain(each) for each in cell.outputs if each.get("name") != "stderr"]
    return notebook


def _plain(output: nbformat.NotebookNode) -> nbformat.NotebookNode:
    if "execution_count" in output:
        output.execution_count = None
    for key in ("text/plain", "text/html"):
        if key in output.get("data", {}):
            output.data[key] = _SECONDS.sub("… s", _PATH.sub("", output.data[key]))
    if "text" in output:
        output.text = _SECONDS.sub("… s", _PATH.sub("", output.text))
    return output


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("notebooks", nargs="*", type=Path, help="files; all of examples/ by default")
    for each in parser.parse_args().notebooks or NOTEBOOKS:
        nbformat.write(kept(executed(each)), each)
