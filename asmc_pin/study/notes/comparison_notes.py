"""What a user ought to know about a comparison besides its figures: warnings before and after it is run, and notes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from asmc_pin.controllers import Controller
from asmc_pin.experiment import Experiment
from asmc_pin.experiment.named_robot import trip_words
from asmc_pin.plant import MovingArm, Plant
from asmc_pin.references import check_reference
from asmc_pin.results.ensemble_summary import ends, failures, figures_by_trial
from asmc_pin.sampled.gain_warnings import gain_warnings
from asmc_pin.sampled.noise.noise_warnings import noise_warnings
from asmc_pin.study.ensemble import Ensemble
from asmc_pin.study.notes.reference_norms import Lemma1Range
from asmc_pin.study.plant_sensor import sensor_of_plant
from asmc_pin.words.remedy_texts import MBAR_REMEDY


def before_the_run(
    experiment: Experiment,
    plant: Plant,
    moving: Sequence[MovingArm],
    laws: Mapping[str, Controller],
    lemma1: Mapping[str, Lemma1Range],
) -> list[str]:
    """Warnings that can be given before anything is simulated: the reference, Lemma 1 along it, gains.

    Args:
        experiment: As to be run.
        plant: Its plant; its viscous friction counts for the gains, at the low end of its scatter.
        moving: Every arm of the run.
        laws: Its controllers by label.
        lemma1: See `lemma1_along`.
    """
    friction = plant.friction
    warnings = check_reference(
        experiment.build_reference(),
        plant.arm,
        experiment.duration,
        experiment.period,
        coulomb=np.broadcast_to(friction.coulomb, (plant.nv,)),
        viscous=np.broadcast_to(friction.viscous, (plant.nv,)),
        effort_limit=plant.effort_limit,
    )
    lines = [f"reference: {line}" for line in warnings]
    violated: dict[Lemma1Range, list[str]] = {}
    for label, item in lemma1.items():
        if item.verdict == "violated":
            violated.setdefault(item, []).append(label)
    for item, labels in violated.items():
        worst, broken = item.worst, sum(part.verdict == "violated" for part in item.parts)
        several = f", in {broken} of {len(item.parts)} phases and ends of the scatter" if len(item.parts) > 1 else ""
        lines.append(
            f"Lemma 1 is violated along the reference on {worst.about} by the M̄ of {', '.join(labels)}: "
            f"‖I − M⁻¹M̄‖₂ = {worst.upper:.4g} at t = {worst.worst_time:.3f} s{several}; {MBAR_REMEDY}"
        )
    delay = plant.drive.delay if plant.drive is not None else 0.0
    sensor = sensor_of_plant(plant)
    viscous = friction.viscous * (1.0 if plant.spread is None else min(1.0, plant.spread.least_friction))
    arms = {item.words: item.arm for item in moving}
    lines += gain_warnings(arms, laws, experiment.period, delay=delay, sensor=sensor, viscous=viscous)
    weakest = np.atleast_2d(
        np.broadcast_to(plant.effort_limit, np.broadcast_shapes(np.shape(plant.effort_limit), (plant.nv,)))
    )
    return lines + noise_warnings(arms, laws, sensor, experiment.period, delay=delay, effort_limit=weakest.min(axis=0))


def after_the_run(experiment: Experiment, label: str, found: Ensemble) -> list[str]:
    """Warnings about what happened: trials that diverged, a robot that would have stopped, joints out of range."""
    failed, ended = failures(found.rows)[0], ends(found.rows)[0]
    lines = []
    if failed.any():
        first = f"t = {ended[failed].min():.3f} s"
        if len(failed) == 1:
            lines.append(f"{label} diverged at {first}; it has no metrics")
        else:
            lines.append(
                f"{label} diverged in {int(failed.sum())} of {len(failed)} trials, the first at {first}; a trial that "
                "diverged counts as worse than any figure"
            )
    robot = experiment.plant.limits
    if found.trip is not None and robot is not None:
        said = trip_words(robot, found.first.joint_names, found.trip)
        tripped = figures_by_trial(found.rows, "trip_time")[0]
        count = int(np.isfinite(tripped).any(axis=1).sum())
        share = f" (in {count} of {len(failed)} trials, this the first)" if len(failed) > 1 else ""
        lines.append(f"{label}: {said}{share}")
    return lines + [f"{label}: {line}" for line in found.warnings]


def phase_lines(moving: Sequence[MovingArm]) -> list[str]:
    """What the arm carries after t = 0, which titles do not say; nothing where that stays."""
    drawn = moving[0].links
    later = [item for item in moving if item.start > 0 and item.links == drawn]
    carried = [
        f"{item.when} {item.arm.payload.mass:g} kg" if item.arm.payload is not None else f"{item.when} nothing"
        for item in later
    ]
    return [f"titles name the arm of t = 0; it carries {', '.join(carried)}"] if carried else []


def log_lines(log_every: int) -> list[str]:
    """What a result keeps of its trajectories; nothing where it keeps all."""
    if log_every == 1:
        return []
    return [
        f"trajectories.nc and monitors.nc keep one control tick in {log_every}, as do the page's curves and replay; "
        "metrics, verdicts and figures/ are of every tick"
    ]
