"""The paper's tables and figures, printed and measured side by side, and its claims judged one by one."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition import lemma1_norm
from asmc_pin.disk.files import whole_folder, write_whole
from asmc_pin.disk.reading import user_path
from asmc_pin.engine import Rollout
from asmc_pin.experiment import Experiment, load_experiment
from asmc_pin.reproduction.error_bounds import limits
from asmc_pin.reproduction.measured_figures import certainly_above, measure, rms_by_trial, theorems
from asmc_pin.reproduction.paper_claims import judged_claims
from asmc_pin.reproduction.paper_figures import draw_reproduction
from asmc_pin.reproduction.printed_tables import PAPER, PROPOSED, RECONCILED, TUNED_SUFFIX, known
from asmc_pin.reproduction.reading_search import factor, nearest_readings, outcomes, reconciled
from asmc_pin.reproduction.readings import AXES, DEG, ERRORS, ReadingOutcome, readings
from asmc_pin.reproduction.reproduction_page import page, summary_lines
from asmc_pin.reproduction.tuned_rows import COMMAND, tune_rows, write_tuned
from asmc_pin.results import result_writing
from asmc_pin.results.result_folder import load_result
from asmc_pin.study.comparing import compare
from asmc_pin.study.comparison import Comparison
from asmc_pin.study.comparison_files import Progress
from asmc_pin.words.shown import Shown

SETS = {
    "simulation": ("baek2016_simulation_smooth", "baek2016_simulation_step"),
    "experiment": ("baek2016_experiment",),
}
"""Experiments of the paper that share their gains, so that one reading has to serve them all."""

# What the reconciled files have: checked against the search whenever it is run.
READINGS: dict[str, dict[str, str]] = {
    "simulation": {"gains": "β × 180/π", "errors": "rad"},
    "experiment": {"adaptation": "s and k̂ in degrees"},
}
DATA, PAGE, TUNED = "reproduction.json", "reproduction.md", "tuned"


@dataclass(frozen=True, repr=False)
class Reproduction(Shown):
    """The paper and what was measured.

    Attributes:
        out: Folder with the page, its data, its figures, and a result for every experiment.
        data: What the page is made from; valid JSON.
    """

    out: Path
    data: dict[str, Any]

    def lines(self) -> list[str]:
        """What a person reads first."""
        return [*summary_lines(self.data), f"page: {self.out / PAGE}"]

    def to_json_dict(self) -> dict[str, Any]:
        """All figures and verdicts, valid JSON."""
        return {"out": str(self.out), **self.data}


def reproduce(
    names: Sequence[str] | None = None,
    out: str | Path = "results/reproduction",
    *,
    force: bool = False,
    search: bool = True,
    tune: bool = False,
    docs: str | Path | None = None,
    progress: Progress | None = None,
) -> Reproduction:
    """Run the paper's experiments, as printed and as reconciled, and write the page that compares.

    Args:
        names: Some of `asmc_pin.reproduction.printed_tables.NAMES`; all when omitted.
        out: Folder of the page and of the results.
        force: Whether results that are there already may be replaced.
        search: Whether to try other readings of units and gains, where `names` has all experiments that share them.
        tune: Whether to tune the laws anew first; the experiments with these rows go to ``tuned`` in `out`, and run.
        docs: Folder to write the page into as well, with its data and figures in a folder ``reproduction`` beside it.
        progress: Called now and then.

    Raises:
        ExperimentError: a name is unknown.
        ResultError: something is there that may not be replaced.
    """
    wanted = known(names)
    folder = user_path(out)
    for name in wanted:
        result_writing.check_target(folder / name, force)
    tell = progress or (lambda _what, _share: None)
    sets = [key for key, members in SETS.items() if search and set(members) <= set(wanted)]
    steps = len(wanted) * (2 if tune else 1) + len(sets)
    done = 0

    def part(what: str, share: float) -> None:
        tell(what, (done + share) / steps)

    def of(name: str) -> Progress:
        return lambda what, share: part(f"{name}: {what}", share)

    found: dict[str, Any] = {}
    for name in wanted:
        experiment = load_experiment(name)
        if tune:
            experiment = load_experiment(write_tuned(tune_rows(experiment, of(name)), folder / TUNED))
            done += 1
        told = _Told(experiment, PAPER[name.removesuffix(RECONCILED)].window)
        comparison = compare(experiment, folder / name, force, of(name), each=told)
        found[name] = _experiment(name, comparison, told.figures())
        done += 1
    searched = {}
    for key in sets:
        part("other readings of the units", 0.0)
        searched[key] = _search(SETS[key])
        done += 1
    bounds = {name: limits(load_experiment(name), PAPER[name]) for name in wanted if name in PAPER}
    data = {"command": COMMAND, "experiments": found, "readings": searched, "limits": bounds}
    _write(folder, data, docs)
    tell("done", 1.0)
    return Reproduction(folder, data)


def reading_of(name: str) -> dict[str, str]:
    """The reading of an experiment, on every axis."""
    base = {axis: options[0] for axis, options in AXES.items()}
    if not name.endswith(RECONCILED):
        return base
    own = next(key for key, members in SETS.items() if name.removesuffix(RECONCILED) in members)
    return base | READINGS[own]


class _Told:
    """Measures every controller of an experiment while its trials are there."""

    def __init__(self, experiment: Experiment, window: float | None) -> None:
        self._laws = {label: str(table["law"]) for label, table in experiment.controllers.items()}
        self._window = window
        self._told: dict[str, dict[str, Any]] = {}
        self._rms: dict[str, Array] = {}

    def __call__(self, label: str, run: Rollout) -> None:
        self._told[label] = measure(run, self._laws[label], self._window)
        self._rms[label] = rms_by_trial(run, self._window)

    def figures(self) -> dict[str, dict[str, Any]]:
        """What was measured, by label, and which others are larger with certainty."""
        above = certainly_above(self._rms)
        return {label: {**told, "certainly_above": above[label]} for label, told in self._told.items()}


def _experiment(name: str, comparison: Comparison, told: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Everything that the page says of one experiment."""
    printed = PAPER[name.removesuffix(RECONCILED)]
    reading = reading_of(name)
    # The paper's errors in the unit in which they are read: in deg, or rad called deg.
    unit = 1.0 / ERRORS[reading["errors"]]
    paper = {label: [unit * x for x in values] for label, values in printed.rms_deg.items()}
    run = comparison.dataset.sel(controller=PROPOSED).isel(trial=0)
    q = run.q.to_numpy()
    mbar = np.asarray(getattr(comparison.experiment.build_controllers()[PROPOSED], "mbar", 0.0))
    alive = np.isfinite(q).all(axis=1)
    norm = lemma1_norm(comparison.arm.mass_matrix(q[alive]), mbar)
    own = comparison.experiment.controllers
    return {
        "title": printed.title,
        "set": "reconciled" if name.endswith(RECONCILED) else "as printed",
        "table": printed.table,
        "window": printed.window,
        "figures": dict(printed.figures),
        "reading": {axis: option for axis, option in reading.items() if option != AXES[axis][0]},
        "paper": {
            "unit": reading["errors"],
            "rms_deg": paper,
            "max_error_deg": [unit * x for x in printed.error_deg],
            "torque": printed.torque,
            "gain": dict(printed.gain),
            "s": list(printed.s),
        },
        "scale": _scales(reading),
        "trials": comparison.experiment.ensemble.trials,
        "q0_deviation": comparison.experiment.ensemble.q0_deviation,
        "controllers": told,
        "tuned": {
            label: {key: value for key, value in own[label].items() if key != "law"}
            for label in own
            if label.endswith(TUNED_SUFFIX)
        },
        "existing_epsilon": {label: own[label]["epsilon"] for label in own if own[label]["law"] == "plestan2010"},
        "theorems": theorems(comparison.experiment, PROPOSED),
        "claims": judged_claims(told, [float(norm.min()), float(norm.max())], printed),
    }


def _scales(reading: dict[str, str]) -> dict[str, float]:
    """Factors from rad to what the figures of s and k̂ are read in."""
    degrees = reading["adaptation"] == "s and k̂ in degrees"
    return {"s": DEG if degrees else 1.0, "gain": DEG if degrees else 1.0}


def _search(members: Sequence[str]) -> dict[str, Any]:
    """Other readings of the experiments that share their gains."""
    experiments = [load_experiment(name) for name in members]
    printed = [PAPER[name] for name in members]
    alone = list(zip(*(outcomes(item, readings(combined=False)) for item in experiments), strict=True))
    together = list(zip(*(outcomes(item, readings(combined=True)) for item in experiments), strict=True))
    ladder = nearest_readings([*alone, *together], printed)
    taken = reconciled(ladder)
    return {
        "members": list(members),
        "tried": len({str(x[0].reading) for x in [*alone, *together]}),
        "alone": [_told(item) for item in alone],
        "ladder": [_told(item) for item in ladder],
        "taken": _told(taken),
    }


def _told(parts: Sequence[ReadingOutcome]) -> dict[str, Any]:
    off = factor(parts)
    changed = {axis: option for axis, option in parts[0].reading.items() if option != AXES[axis][0]}
    finite = np.isfinite(off)
    return {
        "reading": changed,
        "factor": float(off) if finite else None,
        "rms": [{label: list(map(float, x)) for label, x in part.rms_deg.items()} for part in parts]
        if finite
        else None,
        "torque": [part.torque for part in parts] if finite else None,
    }


def _write(folder: Path, data: dict[str, Any], docs: str | Path | None) -> None:
    """The page, its data and its figures; and a copy of them for the documentation."""
    figures = folder / "figures"
    loaded = {name: load_result(folder / name).dataset for name in data["experiments"]}
    with whole_folder(figures) as made:
        drawn = draw_reproduction(data, loaded, made)
    data["figures"] = drawn
    text = json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    write_whole(folder / DATA, text)
    write_whole(folder / PAGE, page(data, "figures"))
    if docs is None:
        return
    beside = Path(docs) / "reproduction"
    beside.mkdir(parents=True, exist_ok=True)
    for name in drawn:
        write_whole(beside / f"{name}.png", (figures / f"{name}.png").read_bytes())
    write_whole(beside / DATA, text)
    write_whole(Path(docs) / PAGE, page(data, "reproduction"))
