"""Comparing an arm's M, bias and motion with MuJoCo's."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.agreement.agreement_report import TOLERANCE, AgreementReport, Verdict
from asmc_pin.agreement.mujoco_model import Twin, import_mujoco, unheard_warnings
from asmc_pin.agreement.playback import Nowhere, Playback
from asmc_pin.arms import Arm
from asmc_pin.clock import Clock
from asmc_pin.engine import rollout
from asmc_pin.errors import NotComparableError, ParameterError
from asmc_pin.plant import Friction, Plant
from asmc_pin.words.given import check_arm

SPEED = 2.0
"""Joint velocities are drawn from ±2 rad/s (m/s), or from within the declared limit where that is less."""
PUSH = 3.0
"""The torques of the runs hold the arm at its start, and on top accelerate each joint by itself by up to 3 rad/s²."""
SETTLED = 0.1
"""A run is integrated well enough to be compared if half the step moves it by less than this part of its travel."""
_SHORTER = "are its lengths in m and its masses in kg? In Python, agree(arm, step=…) takes shorter steps"


def agree(
    arm: Arm, *, configurations: int = 200, runs: int = 8, duration: float = 0.2, step: float = 1e-3, seed: int = 0
) -> AgreementReport:
    """Compare an arm with MuJoCo, which reads the same URDF text.

    M(q) and C(q, q̇)q̇ + g(q) are compared at random configurations of the joint box; motions of our plant and of MuJoCo
    under the same torques without friction, both integrated by the classical Runge-Kutta scheme with the same step, so
    that only the dynamics differ. Payload, armature, gravity and locks of the arm are set in MuJoCo too; limits are
    off.

    Args:
        arm: The arm; its meshes are not needed.
        configurations: How many pairs (q, q̇), at least 1.
        runs: How many motions, at least 1.
        duration: Length of each, s.
        step: Integration step, s.
        seed: Of the configurations and torques.

    Returns:
        The largest differences, and where. ``not compared`` where MuJoCo refuses the URDF.

    Raises:
        MissingDependencyError: MuJoCo is not installed; the message says how to install it.
        ParameterError: a parameter is out of its range.
    """
    check_arm(arm)
    for name, value in (("configurations", configurations), ("runs", runs)):
        if value < 1:
            raise ParameterError(name, f"{value} given, at least 1 expected")
    if not 0.0 < step <= duration:
        raise ParameterError("step", f"{step} s given for runs of {duration} s, above 0 and not longer expected")
    clock = Clock()
    import_mujoco()
    settings = {"configurations": configurations, "runs": runs, "duration": duration, "step": step}
    try:
        twin = Twin(arm)
    except NotComparableError as refusal:
        return _report(arm, f"MuJoCo {import_mujoco().__version__}", settings, "not compared", (str(refusal),), clock)
    generator = np.random.default_rng(seed)
    notes = twin.notes
    with unheard_warnings():
        mass, bias = _compare_terms(arm, twin, *_states(arm, configurations, generator))
        motion = _compare_motion(arm, twin, generator, runs, duration, step)
    # An error that is NaN is not within.
    verdict: Verdict = "agrees" if mass.error <= TOLERANCE and bias.error <= TOLERANCE else "disagrees"
    if motion is None:
        motion = _Found(*np.full((3, arm.nv), np.nan))
        verdict = "not compared" if verdict == "agrees" else verdict
        notes += (f"no motion was compared: steps of {1e3 * step:g} ms are too long for it; {_SHORTER}",)
    elif not motion.error <= TOLERANCE:
        verdict = "disagrees"
    return _report(
        arm,
        twin.engine,
        settings,
        verdict,
        notes,
        clock,
        mass_error=mass.error,
        mass_worst_q=mass.q,
        mass_by_joint=mass.by_joint,
        bias_error=bias.error,
        bias_worst_q=bias.q,
        bias_worst_v=bias.v,
        bias_by_joint=bias.by_joint,
        motion_error=motion.error,
        motion_worst_q=motion.q,
        motion_by_joint=motion.by_joint,
    )


class _Found(NamedTuple):
    """Largest error per joint, (nv,), and the state that gives the largest of all."""

    by_joint: Array
    q: Array
    v: Array

    @property
    def error(self) -> float:
        return float(np.max(self.by_joint))


def _worst(errors: Array, q: Array, v: Array) -> _Found:
    """Of errors of shape (samples, nv)."""
    where = int(np.argmax(np.where(np.isnan(errors), np.inf, errors).max(axis=1)))
    return _Found(errors.max(axis=0), q[where], v[where])


def _states(arm: Arm, count: int, generator: np.random.Generator) -> tuple[Array, Array]:
    """Configurations of the joint box, a metre to each side where a slide declares no range, and velocities."""
    lower, upper = arm.lower.copy(), arm.upper.copy()
    reach = np.where([kind == "prismatic" for kind in arm.joint_kinds], 1.0, np.pi)
    lower = np.where(np.isfinite(lower), lower, np.where(np.isfinite(upper), upper - 2.0 * reach, -reach))
    upper = np.where(np.isfinite(upper), upper, lower + 2.0 * reach)
    speed = np.minimum(SPEED, arm.velocity_limit)
    return generator.uniform(lower, upper, (count, arm.nv)), generator.uniform(-speed, speed, (count, arm.nv))


def _compare_terms(arm: Arm, twin: Twin, q: Array, v: Array) -> tuple[_Found, _Found]:
    pairs = [twin.mass_and_bias(*state) for state in zip(q, v, strict=True)]
    mass, bias = arm.mass_matrix(q), arm.bias(q, v)
    root = np.sqrt(np.diagonal(mass, axis1=1, axis2=2))
    error = np.abs(mass - np.array([pair[0] for pair in pairs])) / (root[:, :, None] * root[:, None, :])
    # A joint on a vertical axis feels no gravity, and a first joint alone no Coriolis torque: 0 against 0.
    scale = np.maximum(np.abs(bias).max(axis=0), (root**2).max(axis=0))
    difference = np.abs(bias - np.array([pair[1] for pair in pairs])) / scale
    return _worst(error.max(axis=2), q, v), _worst(difference, q, v)


def _compare_motion(
    arm: Arm, twin: Twin, generator: np.random.Generator, runs: int, duration: float, step: float
) -> _Found | None:
    """None where the engines differ and our own runs are unsettled: half the step moves them by a part of the travel.

    An integration that is unstable grows rounding, so that no two engines agree, whatever their dynamics are.
    """
    steps = max(1, round(duration / step))
    q, v = _states(arm, runs, generator)
    v *= 0.5
    diagonal = np.diagonal(arm.mass_matrix(q), axis1=1, axis2=2)
    rate, phase = generator.uniform(5.0, 30.0, (runs, arm.nv)), generator.uniform(0.0, 6.0, (runs, arm.nv))
    wave = np.sin(rate * (step * np.arange(steps))[:, None, None] + phase)
    torque = arm.gravity(q) + PUSH * diagonal * wave  # (steps, runs, nv)
    ours = _run(arm, q, v, torque, step)
    theirs = np.stack([twin.run(q[i], v[i], torque[:, i], step)[0] for i in range(runs)], axis=1)
    travel = np.maximum(np.abs(ours - q).max(axis=0), 1e-3)
    found = _worst(np.abs(ours - theirs).max(axis=0) / travel, q, v)
    if found.error <= TOLERANCE:
        return found
    finer = _run(arm, q, v, np.repeat(torque, 2, axis=0), 0.5 * step)[1::2]
    return found if np.all(np.abs(finer - ours).max(axis=0) <= SETTLED * travel) else None


def _run(arm: Arm, q: Array, v: Array, torque: Array, step: float) -> Array:
    """Motion of the plant without friction, limits and drives.

    Args:
        arm: The arm.
        q: Start, shape (runs, nv).
        v: Start, shape (runs, nv).
        torque: Shape (steps, runs, nv), held over each step.
        step: s.

    Returns:
        q after each step, shape (steps, runs, nv).
    """
    free = Plant(
        arm,
        substeps=1,
        integrator="rk4",
        friction=Friction(),
        effort_limit=np.inf,
        speed_bound=np.inf,
        error_bound=np.inf,
        engine="pinocchio",  # it is Pinocchio that is held against MuJoCo
    )
    law = Playback(torque, step)
    run = rollout(free, law, Nowhere(arm.nv), len(torque) * step, batch=len(q), q0=q, v0=v)
    return run.q[:, 1:].swapaxes(0, 1)


def _report(
    arm: Arm,
    engine: str,
    settings: dict[str, Any],
    verdict: Verdict,
    notes: tuple[str, ...],
    clock: Clock,
    **found: Any,
) -> AgreementReport:
    nothing = np.full(arm.nv, np.nan)
    values: dict[str, Any] = dict.fromkeys(("mass_error", "bias_error", "motion_error"), np.nan)
    arrays = ("mass_worst_q", "bias_worst_q", "bias_worst_v", "motion_worst_q")
    values |= dict.fromkeys((*arrays, "mass_by_joint", "bias_by_joint", "motion_by_joint"), nothing)
    return AgreementReport(
        arm=arm.name,
        sha256=arm.sha256,
        joints=arm.joint_names,
        engine=engine,
        verdict=verdict,
        notes=notes,
        seconds=clock.seconds(),
        **settings,
        **(values | found),
    )
