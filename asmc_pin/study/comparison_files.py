"""The files of a comparison: what was run first, and then what is drawn of it."""

from __future__ import annotations

import functools
import json
import math
from collections.abc import Callable
from datetime import datetime
from pathlib import Path

import numpy as np

from asmc_pin.arms import Arm
from asmc_pin.experiment import Experiment
from asmc_pin.pages.comparison_figures import draw_figures
from asmc_pin.pages.latex_table import latex_table
from asmc_pin.pages.theorem_tables import theorems_latex
from asmc_pin.plant import Plant
from asmc_pin.results import result_folder, result_writing
from asmc_pin.results.kept_ticks import kept_ticks
from asmc_pin.results.provenance import provenance
from asmc_pin.study.comparison import Comparison
from asmc_pin.study.summary_text import summary_markdown
from asmc_pin.words.text import printable

Progress = Callable[[str, float], None]
"""Told what is being done, and which share of all is done, 0 to 1."""

SIMULATION = 0.8
"""Share of the time that the runs take, roughly; the rest is writing and drawing."""


def write_comparison(
    comparison: Comparison, plant: Plant, folder: Path, started: datetime, seconds: dict[str, float], tell: Progress
) -> list[str]:
    """Every file of the result, into an empty folder; what was run first, and then what is drawn of it.

    Returns:
        What could not be drawn, in words: a run that may have taken hours is not lost over a picture.
    """
    from asmc_pin.pages.comparison_page import report_html

    experiment, arm, rows = comparison.experiment, comparison.arm, comparison.rows
    tell("writing", SIMULATION)
    (folder / result_folder.EXPERIMENT).write_text(experiment.to_toml(), encoding="utf-8")
    # What a user ought to be told stays with the figures, so that a report made later says it too.
    told = {"notes": "\n".join(comparison.notes), "warnings": "\n".join(comparison.warnings)}
    kept = kept_ticks(comparison.dataset.assign_attrs(told), experiment.log_every)
    result_writing.write_trajectories(kept, folder / result_folder.TRAJECTORIES)
    result_writing.write_summary(rows, folder / result_folder.SUMMARY)
    (folder / "summary.md").write_text(summary_markdown(comparison), encoding="utf-8")
    latex = "\n".join([latex_table(rows), theorems_latex(comparison.theorems.claims, comparison.about.title)])
    (folder / "summary.tex").write_text(latex, encoding="utf-8")
    comparison.theorems.write(folder, experiment.log_every)
    if arm.provisos:
        (folder / result_folder.EXPANDED).write_text(arm.urdf_text, encoding="utf-8")
    figures = folder / "figures"
    tell("figures", SIMULATION + 0.03)
    lost = _drawn("figures", lambda: draw_figures(comparison.dataset, figures, np.asarray(plant.effort_limit)))
    lost += _drawn("the theorems' figure", lambda: comparison.theorems.draw(figures))
    tell("report", SIMULATION + 0.12)
    _write_provenance(experiment, arm, folder, started, seconds)
    # The result is our own, and as large as the run was.
    own = functools.partial(result_folder.load_result, folder, largest=math.inf)
    lost += _drawn("report.html", lambda: report_html(own(), folder / "report.html"))
    _write_provenance(experiment, arm, folder, started, seconds)
    return lost


def _drawn(what: str, draw: Callable[[], object]) -> list[str]:
    try:
        draw()
    except OSError:
        raise  # a full disk has no room for the result either
    except Exception as error:
        said = printable(" ".join(str(error).split()))
        return [f"{what} could not be drawn ({type(error).__name__}: {said}); the result itself is whole"]
    return []


def _write_provenance(
    experiment: Experiment, arm: Arm, folder: Path, started: datetime, seconds: dict[str, float]
) -> None:
    """Written before the report too, which is made from the result as it can be read back."""
    path = folder / result_folder.PROVENANCE
    path.unlink(missing_ok=True)
    text = json.dumps(provenance(experiment, arm, started, seconds, folder), indent=2, ensure_ascii=False)
    path.write_text(text + "\n", encoding="utf-8")
