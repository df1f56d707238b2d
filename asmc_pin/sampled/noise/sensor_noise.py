r"""Noise of the sensors in torque and error, by the linear map of the sampled loop. Derived in docs/stability.md.

White noise n of covariance Q enters z_{k+1} = F z_k + S n_{k+1}; the covariance of z is the X with X = F X Fᵀ + S Q Sᵀ,
and with it that of the torque M̄Uz and of the error. A reading that is rounded to counts Δ has, where the joint crosses
counts every period, an error like white noise of variance Δ²/12. Where it does not, all that is known is that the error
is at most Δ/2: then no more than Δ/2 · Σ|impulse response| comes of it, in whatever order the roundings come.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.sampled.noise.noise_response import noise_rms, rounding_bound
from asmc_pin.sampled.noise.sensor_model import LoopSensor
from asmc_pin.sampled.sampled_loop import SampledLoop
from asmc_pin.sampled.workspace_worst import Workspace

_SAMPLES = 128
_FINEST = 0.02  # of a joint's range: a variance is flat about its maximum
_BOUNDED_AT = 8


@dataclass(frozen=True, eq=False)
class LoopNoise:
    """What the sensors' noise makes of torque and error, the worst that was found, joint by joint.

    Attributes:
        sensor: The sensors.
        count_torque: See `count_torque`, shape (nv,), N·m; None without encoders.
        share: Share of it that filters let through at once.
        torque_rms: RMS of the commanded torque about its mean, shape (nv,), N·m; inf for an unstable loop. Rounding
            counts as noise, as where counts are crossed every period.
        error_rms: RMS of the error q_d − q, shape (nv,), rad (m).
        torque_bound: Largest torque that rounding alone can cause anywhere, at rest too, shape (nv,), N·m; None without
            encoders.
        error_bound: Largest error likewise, rad (m).
        worst: Points of the workspace at which the RMS of each joint's torque is largest, (nv, …).
        places: Of each of them the configuration, payload, armature and locked joints, by name.
        among: What of the ranges they have, in words, the same once only; empty without ranges.
        configurations: Points tried.
    """

    sensor: LoopSensor
    count_torque: Array | None
    share: float
    torque_rms: Array
    error_rms: Array
    torque_bound: Array | None
    error_bound: Array | None
    worst: Array
    places: tuple[dict[str, Any], ...]
    among: tuple[str, ...]
    configurations: int

    def to_json_dict(self) -> dict[str, Any]:
        """Every figure by name; undefined ones are None."""
        return {
            "count_torque": _listed(self.count_torque),
            "torque_noise_rms": _listed(self.torque_rms),
            "error_noise_rms": _listed(self.error_rms),
            "torque_noise_bound": _listed(self.torque_bound),
            "error_noise_bound": _listed(self.error_bound),
            "encoder_count": _listed(self.sensor.count if self.sensor.count.any() else None),
            "velocity_noise": _listed(self.sensor.rate_noise),
            "reported_torque_noise": _listed(self.sensor.torque_noise),
            "torque_noise_worst": list(self.places),
        }

    def lines(self, loop: SampledLoop) -> list[str]:
        """The findings in plain words."""
        text = []
        if self.count_torque is not None:
            text.append(count_line(self.count_torque, self.share, loop))
        if not np.isfinite(self.torque_rms).all():
            return [*text, "noise: none that is stationary, for the loop is unstable"]
        speed = self.sensor.count / loop.period
        where = f" where counts are crossed every period, above {_numbers(speed)} rad/s" if speed.any() else ""
        text.append(
            f"noise{where}: torque RMS to {_numbers(self.torque_rms)} N·m, error RMS to "
            f"{_numbers(np.rad2deg(self.error_rms))} deg, the worst of {self.configurations} configurations"
            + (f" over the ranges; the torques at {'; '.join(self.among)}" if self.among else "")
        )
        if self.torque_bound is not None and self.error_bound is not None:
            text.append(
                f"at any speed rounding moves the torque by {_numbers(self.torque_bound)} N·m at most and the error by "
                f"{_numbers(np.rad2deg(self.error_bound))} deg, where the noise is worst"
            )
        return text


NOISE_KEYS = (
    "count_torque", "torque_noise_rms", "error_noise_rms", "torque_noise_bound", "error_noise_bound",
    "encoder_count", "velocity_noise", "reported_torque_noise", "torque_noise_worst",
)  # fmt: skip
"""Keys of `LoopNoise.to_json_dict`, null in a report that was not asked for noise."""


def count_torque(loop: SampledLoop, count: Array) -> Array:
    """Torque that one count of the encoder is worth, shape (nv,), N·m.

    m̄ Δq/L² where q̈(t−L) is a second difference of readings. Where v is measured and so is differenced once, a count is
    only seen by the feedback of the angle: m̄ β k_s Δq.

    Args:
        loop: Gains and timing.
        count: Δq at the joint, shape (nv,), rad (m).
    """
    per_angle = 1.0 / loop.period**2 if loop.differences_twice else loop.kp
    return np.asarray(loop.mbar * count * per_angle)


def count_formula(loop: SampledLoop) -> str:
    """The same as a formula."""
    return "m̄ Δq/L²" if loop.differences_twice else "m̄ β k_s Δq"


def filtered_share(loop: SampledLoop) -> float:
    """Share of `count_torque` that filters let through in the period of the count."""
    if not loop.differences_twice:
        return 1.0
    return loop.smoothing * (loop.velocity_smoothing if loop.acceleration == "velocity" else 1.0)


def count_line(torque: Array, share: float, loop: SampledLoop) -> str:
    """What one count is worth, in words."""
    through = "" if share == 1.0 else f", of which the filter lets {100.0 * share:.3g} % through at once"
    return f"one count of the encoder is worth {count_formula(loop)} = {_numbers(torque)} N·m of torque{through}"


def loop_noise(workspace: Workspace, loop: SampledLoop, sensor: LoopSensor, *, quick: bool = False) -> LoopNoise:
    """The sensors' noise in torque and error, each joint's the worst over a workspace, its ranges included.

    Args:
        workspace: Where the arm works; about rest under gravity, if that acts.
        loop: Gains and timing; how v is made there, too.
        sensor: The sensors.
        quick: Whether the worst of a few samples is enough, and bounds are not needed.
    """
    space = workspace.thinned(_SAMPLES, _FINEST)

    def figures(points: Array) -> Array:
        """Torque and error of every joint, shape (count, 2nv)."""
        mass, stiffness = space.frozen(points)
        rms = noise_rms(mass, loop, sensor, viscous=space.viscous, stiffness=stiffness)
        return np.concatenate(rms, axis=-1)

    at_samples = figures(space.points)
    worst, points, tried = at_samples.max(axis=0), space.points[at_samples.argmax(axis=0)], len(space.points)
    if np.isfinite(worst).all() and not quick:
        climbs = [
            space.maximise(lambda q, i=i: figures(q)[:, i], at_samples[:, i])  # type: ignore[misc]
            for i in range(2 * loop.nv)
        ]
        worst, points = np.array([value for value, _, _ in climbs]), np.array([point for _, point, _ in climbs])
        tried += sum(more - len(space.points) for _, _, more in climbs)
    rounded = bool(sensor.count.any())
    bounds: tuple[Array | None, Array | None] = (None, None)
    if rounded and np.isfinite(worst).all() and not quick:
        mass, stiffness = space.frozen(np.concatenate([points, space.points[:_BOUNDED_AT]]))
        torque, error = rounding_bound(mass, loop, sensor.count, viscous=space.viscous, stiffness=stiffness)
        bounds = torque.max(axis=0), error.max(axis=0)
    found = [space.arms.place(point) for point in points[: loop.nv]]
    return LoopNoise(
        sensor=sensor,
        count_torque=count_torque(loop, sensor.count) if rounded else None,
        share=filtered_share(loop),
        torque_rms=worst[: loop.nv],
        error_rms=worst[loop.nv :],
        torque_bound=bounds[0],
        error_bound=bounds[1],
        worst=points[: loop.nv],
        places=tuple(
            {"q": space.arms.q(point).tolist(), **where}
            for point, (where, _) in zip(points[: loop.nv], found, strict=True)
        ),
        among=tuple(dict.fromkeys(said for _, said in found if said)),
        configurations=tried,
    )


def _listed(values: Array | None) -> list[float] | None:
    return values.tolist() if values is not None and np.isfinite(values).all() else None


def _numbers(values: Array) -> str:
    return "(" + ", ".join(f"{value:.3g}" for value in values) + ")"
