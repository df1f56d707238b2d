"""The notebooks of examples/ run from top to bottom, show what they make, and are kept small and without traces."""

from __future__ import annotations

import ast
import copy
import re

import nbformat
import pytest
from notebooks import NOTEBOOKS, executed, kept
from test_examples import private_imports

by_name = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)


def outputs_as_text(notebook):
    return "\n".join(str(each.get("data", each)) for cell in notebook.cells for each in cell.get("outputs", []))


@by_name
def test_a_notebook_is_small_and_says_nothing_of_the_machine_that_ran_it(path):
    text = path.read_text(encoding="utf-8")
    assert len(text) < 300_000
    assert not re.search(r"/(tmp|home|root|work|usr|Users)/", text)
    assert not re.search(r", [\d.]+ s\)", text)
    for cell in nbformat.reads(text, as_version=4).cells:
        if cell.cell_type == "code":
            assert cell.execution_count is None
            assert private_imports(ast.parse(cell.source)) <= {"asmc_pin"}


@pytest.mark.long
@by_name
def test_a_notebook_runs_and_its_objects_show_themselves(path):
    notebook = executed(path)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert "text/html" in outputs_as_text(notebook)
    for cell in cells:
        if "scene" in cell.metadata.get("tags", []):
            (output,) = cell.outputs
            assert "<iframe srcdoc=" in output.data["text/html"]
            assert "meshcat" in output.data["text/html"].lower()
        assert not any(output.output_type == "error" for output in cell.outputs)
    committed = nbformat.read(path, as_version=4)
    assert [len(cell.get("outputs", [])) for cell in kept(notebook).cells] == [
        len(cell.get("outputs", [])) for cell in committed.cells
    ], "run python docs/notebooks.py"


def test_a_path_and_a_time_are_taken_out_of_an_output():
    cell = nbformat.v4.new_code_cell("1")
    cell.outputs = [nbformat.v4.new_output("stream", text="report: /tmp/a1/x.html (2 trials, 3.2 s)\n")]
    notebook = nbformat.v4.new_notebook(cells=[copy.deepcopy(cell)])
    assert kept(notebook).cells[0].outputs[0].text == "report: x.html (2 trials, … s)\n"
    notebook = nbformat.v4.new_notebook(cells=[copy.deepcopy(cell)])
    notebook.cells[0].metadata["tags"] = ["scene"]
    assert not kept(notebook).cells[0].outputs
