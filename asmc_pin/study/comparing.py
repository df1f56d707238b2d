"""Running every controller of an experiment on the same plant, and writing the result."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import pandas as pd

from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.arms.frame_kinematics import FrameKinematics
from asmc_pin.baselines import shown_label
from asmc_pin.clock import Clock
from asmc_pin.controllers import Controller
from asmc_pin.engine import Rollout, rollout
from asmc_pin.errors import ExperimentError, ParameterError
from asmc_pin.experiment import Experiment
from asmc_pin.metrics import first_trip
from asmc_pin.plant import Plant, moving_arms
from asmc_pin.results import result_writing
from asmc_pin.results.extra_signals import add_signals
from asmc_pin.study.comparison import Comparison, summary_rows
from asmc_pin.study.comparison_files import SIMULATION, Progress, write_comparison
from asmc_pin.study.ensemble import Ensemble, add_bands, bands, check_size, first_trial, starts
from asmc_pin.study.law_faults import told_of_its_law
from asmc_pin.study.notes.comparison_notes import after_the_run, before_the_run
from asmc_pin.study.notes.reference_norms import lemma1_along
from asmc_pin.study.refinement import Refinement, refinement
from asmc_pin.study.run_monitors import judge_theorems
from asmc_pin.study.tool_rows import add_tool_columns, add_tool_error
from asmc_pin.tool_error import ToolError, tool_error
from asmc_pin.tool_path import tool_path
from asmc_pin.words.given import check_experiment

Each = Callable[[str, Rollout], None]
"""Shown all trials of a controller before they are let go."""


def compare(
    experiment: Experiment,
    out: str | Path | None = None,
    force: bool = False,
    progress: Progress | None = None,
    warn: Callable[[str], None] | None = None,
    refine: bool = False,
    each: Each | None = None,
) -> Comparison:
    """Run every controller of an experiment on the same plant and write the result.

    Each runs in as many trials as ``[ensemble]`` says, in lockstep, from starts that all controllers share. Every
    figure is given by its median and its 5 % and 95 % quantiles; trajectories, figures and theorems are those of
    trial 0, which starts where the experiment says. All are of every control tick, as is the comparison that is
    returned; of its arrays on disk one tick in `log_every` is kept.

    The same experiment gives bitwise the same files on the same machine, but for ``provenance.json``.

    Args:
        experiment: See `asmc_pin.load_experiment`.
        out: Folder of the result; ``results/NAME`` when omitted. It appears whole or not at all.
        force: Whether a result that is there already may be replaced.
        progress: Called now and then.
        warn: Called with every warning as soon as it is known, which for most is before anything is run; all of them
            are in the comparison too.
        refine: Whether to run everything again with half the step, and to say how far each metric moves.
        each: Called with the label and all trials of each controller, of which the comparison keeps the first alone.

    Returns:
        The comparison. A law that diverged has status ``"diverged"`` in it; that is no error.

    Raises:
        ResultError: something is there that may not be replaced.
        ExperimentError: a key does not fit the arm, or a law of one's own raised an exception.
        ArmError: the URDF cannot be used.
    """
    check_experiment(experiment)
    folder = Path(out) if out is not None else Path("results") / experiment.name
    result_writing.check_target(folder, force)
    check_size(experiment)
    tell = progress or (lambda _what, _share: None)
    say = warn or (lambda _line: None)
    tell("loading", 0.0)
    started = datetime.now(UTC)
    plant, laws = experiment.build_plant(), experiment.build_controllers()
    arm = plant.arm
    _check_tool(experiment, arm)
    moving = moving_arms(plant, experiment.period, experiment.duration)
    lemma1 = lemma1_along(moving, *experiment.setpoints(), laws)
    warnings = before_the_run(experiment, plant, moving, laws, lemma1)
    for line in warnings:
        say(line)

    shown = {label: shown_label(label, law) for label, law in laws.items()}
    share = 1.0 / 3.0 if refine else 1.0  # half the step takes twice the time
    found = _ensembles(experiment, plant, laws, shown, lambda what, done: tell(what, share * done), each)
    runs = {label: item.first for label, item in found.items()}
    rows = pd.concat([item.rows for item in found.values()], ignore_index=True)
    after = [line for label, item in found.items() for line in after_the_run(experiment, shown[label], item)]
    refined = None
    if refine:
        refined = _refined(experiment, rows, shown, lambda what, done: tell(what, share + (SIMULATION - share) * done))
        after += refined.warnings()
        rows = rows.join(refined.columns(rows))
    for line in after:
        warnings.append(line)
        say(line)

    comparison = Comparison(
        experiment=experiment,
        arm=arm,
        out=folder,
        rows=rows,
        dataset=result_writing.trajectories(
            arm,
            {shown[label]: run for label, run in runs.items()},
            {shown[label]: experiment.controllers[label]["law"] for label in laws},
        ),
        warnings=tuple(warnings),
        lemma1=lemma1,
        theorems=judge_theorems(plant, runs, laws, shown),
        refinement=refined,
        tool={label: item.tool for label, item in found.items() if item.tool is not None},
        trips={label: item.trip for label, item in found.items() if item.trip is not None},
    )
    add_signals(comparison.dataset, plant, list(runs.values()))
    add_bands(comparison.dataset, {shown[label]: item.bands for label, item in found.items()})
    add_tool_error(comparison.dataset, list(comparison.tool.values()))
    # For who reads the result back: the report, and a person with the trajectories alone.
    comparison.dataset.attrs |= {"warnings": "\n".join(warnings), "notes": "\n".join(comparison.notes)}
    with result_writing.whole_or_not_at_all(folder, force) as made:
        lost = write_comparison(
            comparison, plant, made, started, {label: item.seconds for label, item in found.items()}, tell
        )
    for line in lost:
        say(line)
    tell("done", 1.0)
    return replace(comparison, warnings=(*comparison.warnings, *lost))


def _ensembles(
    experiment: Experiment,
    plant: Plant,
    laws: Mapping[str, Controller],
    shown: Mapping[str, str],
    tell: Progress,
    each: Each | None = None,
) -> dict[str, Ensemble]:
    """What is kept of every law's trials, by label."""
    found, q0 = {}, starts(experiment)
    for i, (label, law) in enumerate(laws.items()):
        clock = Clock()
        run = _run(experiment, plant, label, law, q0, _part(tell, shown[label], i, len(laws)))
        if each is not None:
            each(label, run)
        found[label] = _measured(experiment, plant.arm, label, shown[label], run, clock.seconds())
    return found


def _measured(experiment: Experiment, arm: Arm, label: str, shown: str, run: Rollout, seconds: float) -> Ensemble:
    """The rows of all trials, and the trajectories of the first."""
    rows, tool = summary_rows(experiment, arm, {label: run}, {label: shown}), None
    if experiment.metrics.tool is not None:
        error = tool_error(arm, run, experiment.metrics.tool)
        add_tool_columns(rows, error, tool_path(arm, run, experiment.metrics.tool))
        tool = ToolError(error.frame, error.position[:1], error.rotation[:1])
    trip = first_trip(run, experiment.metric_settings().trips)
    return Ensemble(rows, first_trial(run), bands(run), seconds, run.warnings, tool, trip)


def _refined(experiment: Experiment, rows: pd.DataFrame, shown: Mapping[str, str], tell: Progress) -> Refinement:
    """The same with half the step."""
    substeps = experiment.plant.substeps
    finer = experiment.with_plant(substeps=2 * substeps)
    plant, laws = finer.build_plant(), finer.build_controllers()
    again = {label: f"{name}, half the step" for label, name in shown.items()}
    found = _ensembles(finer, plant, laws, again, lambda what, done: tell(what, done / SIMULATION))
    told = pd.concat([item.rows for item in found.values()], ignore_index=True)
    return refinement(rows, told.assign(controller=rows.controller), substeps)


def _check_tool(experiment: Experiment, arm: Arm) -> None:
    """Say that there is no such tool before anything is run."""
    if experiment.metrics.tool is not None:
        try:
            FrameKinematics(arm, experiment.metrics.tool)
        except ParameterError as error:
            raise ExperimentError("metrics.tool", error.said) from None


def _part(tell: Progress, label: str, index: int, count: int) -> Callable[[int, int], None]:
    tell(label, SIMULATION * index / count)
    return lambda done, total: tell(label, SIMULATION * (index + done / total) / count)


def _run(
    experiment: Experiment,
    plant: Plant,
    label: str,
    law: Controller,
    q0: Array,
    progress: Callable[[int, int], None],
) -> Rollout:
    trials = len(q0)
    with told_of_its_law(experiment, label):
        return rollout(
            plant,
            law,
            experiment.build_reference(),
            experiment.duration,
            period=experiment.period,
            batch=trials,
            q0=q0,
            v0=experiment.plant.v0,
            progress=progress,
            trials=[0] * trials,  # one plant, and one noise of its sensors
        )
