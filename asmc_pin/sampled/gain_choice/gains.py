"""From M̄ to gains: M̄'s scale, β and K_s with stated margins, and the errors to expect."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.condition.domain.arm_ranges import ArmatureRange, LockChoices, PayloadRange
from asmc_pin.condition.domain.joint_box import BoxLike
from asmc_pin.errors import ParameterError
from asmc_pin.sampled.critical_points import Critical, critical_set
from asmc_pin.sampled.error_prediction import drift_error, step_response
from asmc_pin.sampled.frozen_arms import frozen_arms
from asmc_pin.sampled.gain_choice.gain_design import PID, ExpectedErrors, GainDesign
from asmc_pin.sampled.gain_choice.gain_search import USEFUL, GainSearch, Margins, rank_of
from asmc_pin.sampled.gain_choice.hindrances import armature_wanted, hindrances, loudness
from asmc_pin.sampled.gain_choice.law_choice import Bought, best_of_law, checked_law, law_searches
from asmc_pin.sampled.gain_choice.noise_budget import NoiseBudget, budget_of, filtered
from asmc_pin.sampled.gain_choice.pid_tuning import is_pid
from asmc_pin.sampled.gain_choice.stored_pid import pid_loop
from asmc_pin.sampled.loop_analysis import examine, loop_for, spaces_of
from asmc_pin.sampled.noise.sensor_model import LoopSensor, nonnegative_per_joint
from asmc_pin.sampled.sampled_loop import Acceleration, Pairing, SampledLoop
from asmc_pin.sampled.workspace_worst import Workspace
from asmc_pin.words.units import check_delay

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

# Loops whose worst configurations a search begins with, as M̄'s scale, βL and k_sL: damped and stiff, slow and fast.
_BEGINNINGS = ((0.25, 0.2, 3e-4), (0.25, 0.02, 0.02), (0.5, 0.5, 3e-3), (0.1, 0.02, 1e-4))
_AGAIN = 2


def suggest_gains(
    arm: Arm,
    mbar: ArrayLike,
    period: float,
    *,
    acceleration: Acceleration = "velocity",
    filter_hz: float | None = None,
    delay: float = 0.0,
    sensor: LoopSensor | None = None,
    pairing: Pairing = "matched",
    noise_budget: ArrayLike | None = None,
    gain_margin: float = 2.0,
    delay_margin: float = 1.0,
    scale_mbar: bool = True,
    pid: bool = False,
    law: str | None = None,
    settings: Mapping[str, Any] | None = None,
    speed: ArrayLike = 1.0,
    coulomb: ArrayLike | None = None,
    box: BoxLike = None,
    payload: PayloadRange = None,
    armature: ArmatureRange = None,
    lock: LockChoices = None,
    samples: int = 2048,
    seed: int = 0,
) -> GainDesign:
    """M̄'s scale, β and k_s of least error under a drifting load that keep margins over the workspace and ranges.

    A drifting load leaves e = (1 + d) L ḣ/(m̄ β k_s), and a step of load ∫e dt = (1 + d) L h/(m̄ β k_s), so m̄ β k_s is
    made as large as possible; gains with k_s of at least 1/s go before all others. The margins are those of the frozen
    loop at rest under gravity, and of its inertia alone. Where they cannot be had, the largest share of them is.

    With a noise budget a low-pass on q̈(t−L) is chosen too, if none is given: of none and some corner frequencies the
    one whose gains have the largest m̄ β k_s. Where the margins leave no room for it, gains of little noise are given.

    Args:
        arm: The arm.
        mbar: Diagonal of M̄, a scalar or nv values, kg·m²; one that `design` found, say.
        period: Control period L, s.
        acceleration: Estimate of q̈(t−L).
        filter_hz: Low-pass on it, Hz.
        delay: Transport delay, periods.
        sensor: What the drives report, see `loop_sensor`; the truth by default.
        pairing: Torque that goes with the estimate; see `SampledLoop`.
        noise_budget: RMS of torque that the sensor's noise may make, the worst of the workspace, a scalar or nv values,
            N·m; none by default.
        gain_margin: Factor above 1 by which the torque gain may be off, either way.
        delay_margin: Delay that may come on top, periods, 0 or more.
        scale_mbar: Whether M̄ may be scaled down.
        pid: Gains for the PID that PPC is with backward differences, by that PID's own map: it keeps its integral and
            is not told the torque that was applied, so a delay is another to it. Needs a velocity by difference,
            `pairing` ``"last"`` and no filter.
        law: ``"dob"`` or ``"implicit"``: gains for that law, with its low-pass or its share, in the place of PPC's.
            What they are worth against PPC's is then said, with the same margins and no more noise than PPC makes or
            than `noise_budget` allows.
        settings: Parameters of the law's own that are given; a share or cutoff_hz is then not searched.
        speed: Joint speeds for the drift prediction, a scalar or nv values, rad/s.
        coulomb: Coulomb friction for the reversal prediction, a scalar or nv values, N·m; the URDF's by default, or
            1 for every joint where it declares none.
        box: Joint box; the arm's own by default.
        payload: As for `verify`: one, or the ends of a range.
        armature: As for `verify`.
        lock: As for `verify`.
        samples: Number of configurations searched.
        seed: Of the samples.

    Returns:
        Gains, margins and predictions, or why there are none.

    Raises:
        ParameterError: a value cannot be used; the message says what to change.
    """
    ranges: dict[str, Any] = {"payload": payload, "armature": armature, "lock": lock}
    arms = frozen_arms(arm, box, **ranges)
    speed = nonnegative_per_joint("speed", speed, arms.nv, "rad/s")
    coulomb = None if coulomb is None else nonnegative_per_joint("coulomb", coulomb, arms.nv, "N·m")
    plain = None
    if law is not None:
        checked_law(law)
        plain = suggest_gains(
            arm,
            mbar,
            period,
            acceleration=acceleration,
            filter_hz=filter_hz,
            delay=delay,
            sensor=sensor,
            pairing=pairing,
            noise_budget=noise_budget,
            gain_margin=gain_margin,
            delay_margin=delay_margin,
            scale_mbar=scale_mbar,
            speed=speed,
            coulomb=coulomb,
            box=box,
            samples=samples,
            seed=seed,
            **ranges,
        )
        if noise_budget is None and plain.report is not None and plain.report.noise is not None:
            noise_budget = plain.report.noise.torque_rms
    timing: dict[str, Any] = {"acceleration": acceleration, "filter_hz": filter_hz, "delay": delay, "pairing": pairing}
    timing |= {} if sensor is None else sensor.timing
    unit = loop_for(arms.arm, mbar, 1.0, 1.0, period, **timing)
    if pid:
        if law is not None or not is_pid(unit):
            raise ParameterError(
                "pid",
                "is for PPC with velocity by difference, pairing 'last', no filter; take these, and no other law",
            )
        unit = pid_loop(unit)
    asked = asked_margins(gain_margin, delay_margin, period)
    spaces = spaces_of(arms, samples=samples, seed=seed)
    budget = budget_of(noise_budget, sensor, spaces[-1])
    limit = None if budget is None else budget.limit
    search = GainSearch(unit, _beginning(spaces, unit), least=0.05 if scale_mbar else 1.0)

    def choose() -> SampledLoop | None:
        if law is not None and plain is not None:
            goal = asked if plain.met or plain.reached is None else plain.reached
            return best_of_law(law_searches(search, law, settings or {}, budget), goal, unit)
        return _chosen(search, asked) if budget is None else _within(search, asked, budget)

    chosen = choose()
    kind = PID if pid else law or ""
    if chosen is None and law is not None:
        return GainDesign(arms.about, unit, asked, None, None, (), None, limit, law=law)
    if chosen is None:
        why, wanted = hindrances(search.critical, _slow(unit), Margins((1.0, 1.0), 0.0)), armature_wanted(search, asked)
        return GainDesign(arms.about, unit, asked, None, None, why, wanted, limit, law=kind)
    report = examine(spaces, chosen, limits=True, known=list(search.critical.points), sensor=sensor)
    for _ in range(_AGAIN):
        noise = report.noise
        if budget is None or noise is None or not budget.keeps(chosen) or (noise.torque_rms <= budget.limit).all():
            break
        # The report searches further, joint by joint.
        budget.take_in(noise.worst)
        chosen = choose() or chosen
        report = examine(spaces, chosen, limits=True, known=list(search.critical.points), sensor=sensor)
    if coulomb is None:
        coulomb = arms.arm.friction if arms.arm.friction.any() else 1.0
    expected = _expected(search.critical, spaces[-1], chosen, speed, coulomb)
    design = GainDesign(arms.about, unit, asked, report, expected, (), None, limit, law=kind)
    if plain is not None:
        return replace(design, bought=_bought(design, plain))
    if design.met and design.useful and design.quiet:
        return design
    # What stands against more: the margins asked for, or with them a faster k_s.
    faster = chosen if not design.met else chosen.scaled(ks=max(1.0, USEFUL / float(chosen.ks[0])))
    why = hindrances(search.critical, faster, asked)
    if budget is not None:
        # Armature is looked for without a thought for noise, so it is no answer to a budget.
        return replace(design, why=(*why, *loudness(budget, faster)))
    return replace(design, why=why, armature=armature_wanted(search, asked))


def _bought(design: GainDesign, plain: GainDesign) -> Bought | None:
    """What gains of a law are worth against those of PPC; None where PPC has none."""
    mine, others = design.report, plain.report
    if mine is None or others is None or design.expected is None or plain.expected is None:
        return None
    noise = None
    if mine.noise is not None and others.noise is not None:
        noise = mine.noise.torque_rms / others.noise.torque_rms
    stiffness = [report.loop.mbar[0] * report.loop.ks[0] * report.loop.resting_beta[0] for report in (mine, others)]
    ages = [report.loop.torque_age for report in (mine, others)]
    return Bought(
        drift=float(ages[0] / ages[1] * stiffness[1] / stiffness[0]),
        reversal=design.expected.reversal_rms / plain.expected.reversal_rms,
        noise=noise,
        allowed=plain.quiet,
    )


def _chosen(search: GainSearch, asked: Margins) -> SampledLoop | None:
    """The best gains with margins, or with the largest share of them; None where no gains are stable."""
    found = search.with_margins(asked)
    return search.with_most(asked) if found is None else found


def _within(search: GainSearch, asked: Margins, budget: NoiseBudget) -> SampledLoop | None:
    """The best gains within a noise budget, low-pass and all; margins come before the budget where not both are had."""
    tries = [replace(search, loop=loop, budget=budget) for loop in filtered(search.loop)]
    best = None
    for trial in tries:
        found = trial.with_margins(asked)
        if found is not None and (best is None or rank_of(found, search.loop) > rank_of(best, search.loop)):
            best = found
        elif best is not None:
            # Lower corners make less noise and leave less room: once that costs more than it gives, it goes on to.
            return best
    if best is not None:
        return best
    if not search.possible(asked, 0.0):
        found = tries[0].with_most(asked)
        return search.with_most(asked) if found is None else found
    loud = (replace(trial, budget=None).with_least_noise(asked, budget) for trial in tries)
    found = min((loop for loop in loud if loop is not None), key=budget.share, default=None)
    return _chosen(search, asked) if found is None else found


def _beginning(spaces: tuple[Workspace, ...], unit: SampledLoop) -> Critical:
    """The configurations that decide about loops of very different gains."""
    begin = [unit.scaled(mbar=scale, beta=beta / unit.period, ks=ks / unit.period) for scale, beta, ks in _BEGINNINGS]
    known = [space.thinned(512).worst(loop)[1] for space in spaces for loop in begin]
    return critical_set(spaces, begin[0], known)


def _slow(unit: SampledLoop) -> SampledLoop:
    scale, beta, ks = _BEGINNINGS[0]
    return unit.scaled(mbar=scale, beta=beta / unit.period, ks=ks / unit.period)


def _expected(
    critical: Critical, space: Workspace, loop: SampledLoop, speed: ArrayLike, coulomb: ArrayLike
) -> ExpectedErrors:
    nv = loop.nv
    speeds, friction = (np.array(np.broadcast_to(np.asarray(x, dtype=np.float64), (nv,))) for x in (speed, coulomb))
    response = step_response(critical.mass, loop, 2.0 * friction)
    return ExpectedErrors(
        speed=speeds,
        drift=drift_error(loop, _largest_drift(space, speeds)),
        coulomb=friction,
        reversal_peak=np.diagonal(response.peak, axis1=-2, axis2=-1).max(axis=0),
        reversal_rms=response.rms(1.0).max(axis=0),
    )


def _largest_drift(space: Workspace, speeds: Array) -> Array:
    """Largest rate at which gravity's torque on each joint drifts, anywhere in the workspace, shape (nv,), N·m/s."""

    def rates(points: Array) -> Array:
        return np.asarray(np.abs(space.arms.stiffness(points)) @ speeds)

    at_samples = rates(space.points)

    def largest(joint: int) -> float:
        return space.maximise(lambda points: rates(points)[:, joint], at_samples[:, joint])[0]

    return np.array([largest(joint) for joint in range(speeds.size)])


def asked_margins(gain: float, delay: float, period: float) -> Margins:
    """Margins as they are asked for, checked.

    Args:
        gain: Factor by which the torque gain may be off, at least 1.
        delay: Delay that may come on top, periods.
        period: Control period, s.

    Raises:
        ParameterError: a value cannot be used.
    """
    _check("gain_margin", gain, 1.0)
    _check("delay_margin", delay, 0.0)
    check_delay(delay, period, "delay_margin")
    return Margins((1.0 / gain, float(gain)), float(delay))


def _check(name: str, value: float, least: float) -> None:
    if not (isinstance(value, (int, float, np.integer, np.floating)) and math.isfinite(value) and value >= least):
        raise ParameterError(name, f"got {value!r}; expected a number of at least {least:g}")
