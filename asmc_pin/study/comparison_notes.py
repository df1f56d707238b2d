"""What a user ought to know about a comparison besides its figures: warnings, and Lemma 1 along the reference."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from asmc_pin.arms import Arm
from asmc_pin.condition.hypotheses import Hypotheses
from asmc_pin.condition.norm.two_conditions import lemma1_norm
from asmc_pin.condition.premises import hypotheses_on, premises_along
from asmc_pin.controllers import Controller, Setpoint
from asmc_pin.engine import Rollout
from asmc_pin.experiment import Experiment
from asmc_pin.plant import Plant
from asmc_pin.references import check_reference
from asmc_pin.sampled.gain_warnings import gain_warnings
from asmc_pin.sampled.noise_warnings import noise_warnings
from asmc_pin.study.plant_sensor import sensor_of_plant


@dataclass(frozen=True, slots=True, eq=False)
class Lemma1Range:
    """‖I − M⁻¹M̄‖₂ at the configurations of a reference.

    Attributes:
        hypotheses: What it is about: the arm with its rotors, its first payload and its locked joints, and M̄.
        lower: Smallest value.
        upper: Largest value; below 1 at these configurations does not prove it between them, nor off the reference.
        worst_time: When the largest is reached, s.
    """

    hypotheses: Hypotheses
    lower: float
    upper: float
    worst_time: float

    @property
    def verdict(self) -> str:
        """``"violated"``, or ``"unrefuted"``: a sample can refute, never prove."""
        return "unrefuted" if self.upper < 1.0 else "violated"


def lemma1_along(
    arm: Arm, time: np.ndarray, setpoint: Setpoint, laws: Mapping[str, Controller]
) -> dict[str, Lemma1Range]:
    """Lemma 1's norm along the reference, for the M̄ of every law that has one.

    Args:
        arm: The arm.
        time: Shape (T,), s.
        setpoint: Reference there, fields of shape (T, nv).
        laws: Controllers by label.

    Returns:
        By label; one and the same object for all laws with one M̄.
    """
    about = premises_along(arm, setpoint.q)
    mass = arm.mass_matrix(setpoint.q)
    found: dict[str, Lemma1Range] = {}
    known: dict[bytes, Lemma1Range] = {}
    for label, law in laws.items():
        mbar = getattr(law, "mbar", None)
        if mbar is None:
            continue
        diagonal = np.broadcast_to(np.asarray(mbar, dtype=np.float64), (arm.nv,)).copy()
        key = diagonal.tobytes()
        if key not in known:
            norm = lemma1_norm(mass, diagonal)
            worst = int(np.argmax(norm))
            hypotheses = hypotheses_on(about, diagonal, "lemma1")
            known[key] = Lemma1Range(hypotheses, float(np.min(norm)), float(norm[worst]), float(time[worst]))
        found[label] = known[key]
    return found


def before_the_run(
    experiment: Experiment, plant: Plant, laws: Mapping[str, Controller], lemma1: Mapping[str, Lemma1Range]
) -> list[str]:
    """Warnings that can be given before anything is simulated: the reference, Lemma 1 along it, gains.

    Args:
        experiment: As to be run.
        plant: Its plant; its viscous friction counts for the gains.
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
        lines.append(
            f"Lemma 1 is violated along the reference on {item.hypotheses.title} by the M̄ of {', '.join(labels)}: "
            f"‖I − M⁻¹M̄‖₂ = {item.upper:.4g} at t = {item.worst_time:.3f} s; 'asmc-pin design' finds an M̄ that "
            "keeps it below 1"
        )
    delay = plant.drive.delay if plant.drive is not None else 0.0
    sensor = sensor_of_plant(plant)
    lines += gain_warnings(plant.arm, laws, experiment.period, delay=delay, sensor=sensor, viscous=friction.viscous)
    weakest = np.atleast_2d(
        np.broadcast_to(plant.effort_limit, np.broadcast_shapes(np.shape(plant.effort_limit), (plant.nv,)))
    )
    return lines + noise_warnings(
        plant.arm, laws, sensor, experiment.period, delay=delay, effort_limit=weakest.min(axis=0)
    )


def after_the_run(rollouts: Mapping[str, Rollout]) -> list[str]:
    """Warnings about what happened: laws that diverged, joints that left their limits."""
    lines = []
    for label, run in rollouts.items():
        for trial, status in enumerate(run.status):
            if status != "ok":
                where = f" in trial {trial}" if len(run.status) > 1 else ""
                lines.append(f"{label} diverged{where} at t = {run.end_time[trial]:.3f} s; it has no metrics")
        lines += [f"{label}: {line}" for line in run.warnings]
    return lines


def lemma1_lines(lemma1: Mapping[str, Lemma1Range]) -> list[str]:
    """The ranges in words, one line for each M̄."""
    groups: dict[Lemma1Range, list[str]] = {}
    for label, item in lemma1.items():
        groups.setdefault(item, []).append(label)
    return [
        f"Lemma 1 along the reference on {item.hypotheses.title}, with M̄ = {_diagonal(item.hypotheses)} kg·m² of "
        f"{', '.join(labels)}: ‖I − M⁻¹M̄‖₂ = {item.lower:.4f} … {item.upper:.4f}, {item.verdict} (sampled at the "
        "control ticks)"
        for item, labels in groups.items()
    ]


def _diagonal(hypotheses: Hypotheses) -> str:
    return f"diag({', '.join(f'{m:.6g}' for m in hypotheses.mbar)})"
