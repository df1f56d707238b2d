"""The analysis behind `asmc-pin stability`: the worst of a loop over a workspace and ranges, its limits and margins."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.clock import Clock
from asmc_pin.condition.domain.arm_ranges import ArmatureRange, LockChoices, PayloadRange
from asmc_pin.condition.domain.joint_box import BoxLike
from asmc_pin.errors import ParameterError
from asmc_pin.sampled.critical_points import critical_set
from asmc_pin.sampled.frozen_arms import FrozenArms, frozen_arms
from asmc_pin.sampled.loop_limits import margins_and_limits
from asmc_pin.sampled.noise.sensor_model import LoopSensor
from asmc_pin.sampled.noise.sensor_noise import LoopNoise, loop_noise
from asmc_pin.sampled.remedies import remedy
from asmc_pin.sampled.sampled_loop import Acceleration, Pairing, SampledLoop, positive_per_joint
from asmc_pin.sampled.stability_report import StabilityReport, WorstFound
from asmc_pin.sampled.workspace_worst import Workspace, workspace_of
from asmc_pin.words.units import check_delay, check_period

if TYPE_CHECKING:
    from asmc_pin.arms import Arm
    from asmc_pin.controllers import TdeLaw

SAMPLES = 2048
"""Configurations before the local search."""


def stability(
    arm: Arm,
    mbar: ArrayLike,
    ks: ArrayLike,
    beta: ArrayLike,
    period: float,
    *,
    acceleration: Acceleration = "velocity",
    filter_hz: float | None = None,
    delay: float = 0.0,
    sensor: LoopSensor | None = None,
    pairing: Pairing = "matched",
    law: TdeLaw | None = None,
    viscous: ArrayLike | None = None,
    box: BoxLike = None,
    payload: PayloadRange = None,
    armature: ArmatureRange = None,
    lock: LockChoices = None,
    samples: int = SAMPLES,
    seed: int = 0,
    limits: bool = True,
) -> StabilityReport:
    """Analyse the sampled loop (7) on an arm, frozen over its workspace and over ranges.

    Args:
        arm: The arm.
        mbar: Diagonal of M̄, a scalar or nv values, kg·m².
        ks: Diagonal of K_s, a scalar or nv values, 1/s.
        beta: β, 1/s.
        period: Control period L, s.
        acceleration: Estimate of q̈(t−L): "velocity" or "position".
        filter_hz: Low-pass on it, Hz.
        delay: Transport delay of the torque, periods; see docs/stability.md.
        sensor: What the drives report, see `loop_sensor`; the truth by default.
        pairing: Torque that goes with the estimate; see `SampledLoop`.
        law: A law that is linear, at least near its set point, in the place of PPC; with M̄, K_s, β and L as given here,
            and its own estimate of q̈(t−L).
        viscous: Viscous friction to include, a scalar or nv values, N·m·s/rad; none by default, the careful choice.
        box: Joint box; the arm's own by default.
        payload: As for `verify`: one, or the ends of a range.
        armature: As for `verify`.
        lock: As for `verify`.
        samples: Number of configurations before the local search.
        seed: Of the samples.
        limits: Whether to look for largest gains and margins too, which takes most of the time.

    Raises:
        ParameterError: a value has a wrong size, sign, or is not finite.
        ArmError: the box is not finite.
    """
    arms = frozen_arms(arm, box, payload=payload, armature=armature, lock=lock)
    timing: dict[str, Any] = {"acceleration": acceleration, "filter_hz": filter_hz, "delay": delay, "pairing": pairing}
    if sensor is not None and not hasattr(sensor, "timing"):
        raise ParameterError("sensor", f"{sensor!r} given, what loop_sensor makes expected")
    timing |= {"law": law, **({} if sensor is None else sensor.timing)}
    loop = loop_for(arms.arm, mbar, ks, beta, period, **timing)
    friction = None if viscous is None else _viscous(viscous, arms.nv)
    return examine(spaces_of(arms, samples=samples, seed=seed, viscous=friction), loop, limits=limits, sensor=sensor)


def examine(
    spaces: tuple[Workspace, ...],
    loop: SampledLoop,
    *,
    limits: bool,
    known: Sequence[Array] = (),
    sensor: LoopSensor | None = None,
) -> StabilityReport:
    """The report on a loop.

    Args:
        spaces: See `spaces_of`.
        loop: Gains and timing.
        limits: Whether to look for largest gains and margins too.
        known: Points that have decided about loops of this kind.
        sensor: What the drives report.
    """
    clock = Clock()
    arms = spaces[0].arms
    (radius, point, tried), *more = [space.worst(loop) for space in spaces]
    rest_radius, rest_point, rest_tried = more[0] if more else (radius, point, 0)
    (low, _), (high, _) = spaces[0].ratio_range(loop.mbar)
    found, advice = None, ""
    if limits:
        critical = critical_set(spaces, loop, [rest_point, point, *known])
        # First of all, so that `remedy_of` says the same.
        advice = remedy(critical, loop) if max(radius, rest_radius) >= 1.0 else ""
        found = margins_and_limits(critical, loop)
    return StabilityReport(
        about=arms.about,
        gravity=arms.arm.gravity_vector,
        loop=loop,
        bare=_found(arms, radius, point),
        rest=_found(arms, rest_radius, rest_point),
        ratios=(low, high),
        limits=found,
        remedy=advice,
        configurations=tried + rest_tried,
        seconds=clock.seconds(),
        noise=noise_at_rest(spaces, loop, sensor),
    )


def noise_at_rest(spaces: tuple[Workspace, ...], loop: SampledLoop, sensor: LoopSensor | None) -> LoopNoise | None:
    """The sensors' noise in the loop, with gravity if it acts; None if nothing that they report is off."""
    return None if sensor is None or not sensor.noisy else loop_noise(spaces[-1], loop, sensor)


def remedy_of(arms: FrozenArms, loop: SampledLoop, *, seed: int = 0) -> str:
    """What `stability` advises for a loop, without the rest of its report; empty if it finds the loop stable."""
    spaces = spaces_of(arms, samples=SAMPLES, seed=seed)
    (radius, point, _), *more = [space.worst(loop) for space in spaces]
    rest_radius, rest_point, _ = more[0] if more else (radius, point, 0)
    stable = max(radius, rest_radius) < 1.0
    return "" if stable else remedy(critical_set(spaces, loop, [rest_point, point]), loop)


def spaces_of(arms: FrozenArms, *, samples: int, seed: int, viscous: Array | None = None) -> tuple[Workspace, ...]:
    """What a verdict and the margins are looked for on: the inertia alone and, where gravity acts, the arms at rest."""
    return tuple(
        workspace_of(arms, samples=samples, seed=seed, gravity=gravity, viscous=viscous)
        for gravity in (False, True)[: 1 + arms.heavy]
    )


def _found(arms: FrozenArms, radius: float, point: Array) -> WorstFound:
    where, said = arms.place(point)
    return WorstFound(radius, arms.q(point), where, f" ({said})" if said else "")


def loop_for(arm: Arm, mbar: ArrayLike, ks: ArrayLike, beta: ArrayLike, period: float, **timing: Any) -> SampledLoop:
    """The loop with M̄ spread over the arm's joints.

    Raises:
        ParameterError: as of `SampledLoop`, or a period or delay that is hardly meant in its unit.
    """
    loop = SampledLoop(positive_per_joint("mbar", mbar, arm.nv, "kg·m²"), ks, beta, period, **timing)  # type: ignore[arg-type]
    check_period(loop.period)
    check_delay(loop.delay, loop.period)
    return loop


def _viscous(value: ArrayLike, nv: int) -> Array:
    try:
        friction = np.array(np.broadcast_to(np.asarray(value, dtype=np.float64), (nv,)))
    except (TypeError, ValueError):
        raise ParameterError("viscous", f"got {value!r}; expected a number or {nv} of them, in N·m·s/rad") from None
    if not (np.isfinite(friction).all() and (friction >= 0.0).all()):
        raise ParameterError("viscous", f"got {friction.tolist()}; every value must be finite and 0 or more")
    return friction
