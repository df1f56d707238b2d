"""Tracking errors that the linear map predicts: under a drifting load, after friction reverses, along a reference."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.errors import ParameterError
from asmc_pin.sampled.frozen_arms import gravity_stiffness
from asmc_pin.sampled.linear_map import ClosedLoop, closed_loop, spectral_radius
from asmc_pin.sampled.sampled_loop import SampledLoop

if TYPE_CHECKING:
    from asmc_pin.arms import Arm
    from asmc_pin.references.reference import Reference

_CHUNK = 512
_LONGEST = 20_000


def drift_error(loop: SampledLoop, drift: ArrayLike) -> Array:
    r"""Steady error under a load torque that drifts at a constant rate, e = (1 + d) L M̄⁻¹ḣ / (β K_s).

    (3/2 + d) L where two torques are averaged, (1/c + d) L where a law low-passes its whole estimate with weight c; β
    is more by the slope of a law's own term.

    In the steady state (7) adds M̄βK_s e to the torque last reported, and the load has grown by (1 + d)L ḣ since then;
    by half a period more since the mean of the last two.
    M does not enter: the joints do not couple, however full M is. docs/stability.md has the proof.

    Args:
        loop: Gains and timing; how the acceleration is estimated, and filtered, does not matter, but its pairing does.
        drift: ḣ, shape (..., nv), N·m/s.

    Returns:
        e = q_d − q, shape (..., nv), rad; positive where the load grows against positive motion.
    """
    return np.asarray(loop.torque_age * loop.period * np.asarray(drift) / (loop.mbar * loop.resting_beta * loop.ks))


@dataclass(frozen=True)
class StepResponse:
    """Errors after load steps, one joint's load at a time.

    Attributes:
        peak: Largest |e| of joint i after the step on joint j, shape (..., nv, nv), rad.
        energy: ∫ e² dt likewise, shape (..., nv, nv), rad²·s.
    """

    peak: Array
    energy: Array

    def rms(self, per_second: float) -> Array:
        """RMS error of each joint when every joint meets that many such steps per second, shape (..., nv), rad.

        Responses are taken not to overlap.
        """
        return np.asarray(np.sqrt(per_second * self.energy.sum(axis=-1)))


def step_response(mass: Array, loop: SampledLoop, steps: ArrayLike) -> StepResponse:
    """Errors after a step of load torque, such as friction that reverses: a step of twice the Coulomb torque.

    Args:
        mass: M(q), shape (..., nv, nv), kg·m².
        loop: Gains and timing.
        steps: Size of the step on each joint, shape (nv,), N·m.

    Returns:
        Peaks and energies; inf where the loop is unstable.
    """
    size = np.diag(np.broadcast_to(np.asarray(steps, dtype=np.float64), (loop.nv,)))
    system = closed_loop(mass, loop)
    kick = system.load @ size
    angle = system.blocks["q"]
    radius = float(np.max(spectral_radius(mass, loop)))
    if radius >= 1.0:
        endless = np.full(kick[..., angle, :].shape, np.inf)
        return StepResponse(endless, endless)
    ticks = min(_LONGEST, math.ceil(-12.0 / math.log(radius)))
    state = np.zeros_like(kick)
    peak, energy = np.zeros_like(kick[..., angle, :]), np.zeros_like(kick[..., angle, :])
    for _ in range(ticks):
        state = system.matrix @ state + kick
        error = state[..., angle, :]
        np.maximum(peak, np.abs(error), out=peak)
        energy += error**2
    return StepResponse(peak, energy * loop.period)


def reversal_estimate(loop: SampledLoop, coulomb: ArrayLike) -> tuple[Array, Array]:
    r"""Peak and energy of the error after a reversal of Coulomb friction, for an inner loop that is fast (a not small).

    The estimate takes (1 + d)L to catch up with the step 2f ((3/2 + d)L where two torques are averaged), so what
    reaches (8) is a blow of (1 + d)L·2f/m̄ in velocity, answered by
    e(t) = blow · (e^{−k_s t} − e^{−βt})/(β − k_s), of energy blow²/(2 K_d K_p).

    Args:
        loop: Gains and timing.
        coulomb: Coulomb friction, shape (nv,), N·m.

    Returns:
        Peak of |e|, rad, and ∫e² dt, rad²·s, each of shape (nv,).
    """
    blow = loop.torque_age * loop.period * 2.0 * np.asarray(coulomb, dtype=np.float64) / loop.mbar
    ratio = loop.beta / loop.ks
    # The maximum of the response is blow/k_s · r^(−r/(r−1)) with r = β/k_s; 1/e in the limit r → 1.
    apart = np.abs(ratio - 1.0) > 1e-6
    safe = np.where(apart, ratio, 2.0)
    shape = np.where(apart, np.exp(-np.log(safe) * safe / (safe - 1.0)), math.exp(-1.0))
    return np.asarray(blow * shape / loop.ks), np.asarray(blow**2 / (2.0 * loop.kd * loop.kp))


@dataclass(frozen=True)
class TrackingPrediction:
    """Predicted tracking of a reference.

    Attributes:
        time: Ticks, shape (T,), s.
        error: e = q_d − q, shape (T, nv), rad.
    """

    time: Array
    error: Array

    @property
    def rms(self) -> Array:
        """RMS error per joint, shape (nv,), rad."""
        return np.asarray(np.sqrt(np.mean(self.error**2, axis=0)))

    @property
    def peak(self) -> Array:
        """Largest |e| per joint, shape (nv,), rad."""
        return np.asarray(np.abs(self.error).max(axis=0))


def predict_tracking(
    arm: Arm,
    loop: SampledLoop,
    reference: Reference,
    duration: float,
    *,
    coulomb: ArrayLike = 0.0,
    viscous: ArrayLike = 0.0,
) -> TrackingPrediction:
    """Error of (7) along a reference, linearised about it: each tick's map, driven by the torque that the motion needs.

    Coulomb friction is taken to reverse where the reference does; the true joint sticks there for a moment first.

    Args:
        arm: The arm.
        loop: Gains and timing.
        reference: What to follow.
        duration: s, rounded to whole periods.
        coulomb: Coulomb friction, a scalar or nv values, N·m.
        viscous: Viscous friction, a scalar or nv values, N·m·s/rad.

    Returns:
        The prediction; it starts on the reference with the drives holding the arm against gravity.

    Raises:
        ParameterError: the reference is for another number of joints, or the duration is shorter than a period.
    """
    ticks = round(duration / loop.period)
    if reference.nv != arm.nv or loop.nv != arm.nv:
        raise ParameterError(
            "reference", f"has {reference.nv} joints, the loop {loop.nv}, the arm {arm.nv}; they must agree"
        )
    if ticks < 1:
        raise ParameterError("duration", f"{duration} s is less than one control period of {loop.period} s")
    time = np.arange(ticks + 1, dtype=np.float64) * loop.period
    needed = _needed_torque(arm, reference, time[:-1] + 0.5 * loop.period, coulomb, viscous)
    surplus = _surplus(loop, reference, time[:-1])
    error = np.zeros((ticks + 1, arm.nv))
    start = reference.evaluate(time[:1]).q[0]
    state = np.zeros(0)
    for begin in range(0, ticks, _CHUNK):
        now = slice(begin, min(begin + _CHUNK, ticks))
        q = reference.evaluate(time[now]).q
        system = closed_loop(arm.mass_matrix(q), loop, viscous=viscous, stiffness=gravity_stiffness(arm, q))
        if begin == 0:
            state = _holding(system, arm.gravity(start) / loop.mbar)
        push = (system.load @ needed[now, :, None] + system.command @ surplus[now, :, None])[..., 0]
        for k, (matrix, kick) in enumerate(zip(system.matrix, push, strict=True), start=begin + 1):
            state = matrix @ state + kick
            error[k] = -state[system.blocks["q"]]
    return TrackingPrediction(time, error)


def _holding(system: ClosedLoop, command: Array) -> Array:
    """The state of a loop whose drives hold a constant command, at rest on the reference."""
    state = np.zeros(system.matrix.shape[-1])
    for name, where in system.blocks.items():
        if name in ("tde", "report") or name.startswith("command-"):
            state[where] = command
    return state


def _needed_torque(arm: Arm, reference: Reference, time: Array, coulomb: ArrayLike, viscous: ArrayLike) -> Array:
    """Torque that the reference motion needs, M q̈_d + C q̇_d + g + friction, shape (T, nv), N·m."""
    wanted = reference.evaluate(time)
    inertial = np.einsum("kij,kj->ki", arm.mass_matrix(wanted.q), wanted.a)
    friction = np.asarray(coulomb) * np.sign(wanted.v) + np.asarray(viscous) * wanted.v
    return np.asarray(inertial + arm.bias(wanted.q, wanted.v) + friction)


def _surplus(loop: SampledLoop, reference: Reference, time: Array) -> Array:
    """What (7) commands on the reference itself, read and differenced as the joints are, shape (T, nv), rad/s²."""
    wanted = reference.evaluate(time)
    before = time - loop.reading_delay * loop.period
    seen = reference.evaluate(np.maximum(before, 0.0))
    angle = seen.q + np.minimum(before, 0.0)[:, None] * seen.v  # before t = 0 it moves on at v(0)
    slope = np.concatenate([seen.v[:1], np.diff(angle, axis=0) / loop.period])
    rate = seen.v
    if loop.velocity == "difference":
        rate = _low_passed(slope, loop.velocity_smoothing)
    moved = slope if loop.acceleration == "position" else rate
    raw = np.diff(moved, axis=0, prepend=moved[:1]) / loop.period
    estimate = _low_passed(raw, loop.smoothing)
    return np.asarray(wanted.a - estimate + loop.kd * (wanted.v - rate) + loop.kp * (wanted.q - angle))


def _low_passed(values: Array, share: float) -> Array:
    """y_k = y_{k−1} + share·(x_k − y_{k−1}), from y_0 = x_0."""
    out = values.copy()
    for k in range(1, len(out)) if share < 1.0 else ():
        out[k] = out[k - 1] + share * (values[k] - out[k - 1])
    return out
