"""The answer of `asmc-pin stability`: whether the sampled loop is stable over the workspace, and with what margins."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.clock import Clock
from asmc_pin.condition.domain.joint_box import BoxLike, asked_box
from asmc_pin.condition.hypotheses import Premises
from asmc_pin.condition.premises import ends_of, premises_of
from asmc_pin.errors import ParameterError
from asmc_pin.sampled.loop_limits import LoopLimits, limits_of
from asmc_pin.sampled.remedies import remedy
from asmc_pin.sampled.sampled_loop import Acceleration, Pairing, SampledLoop, positive_per_joint
from asmc_pin.sampled.sensor_model import LoopSensor
from asmc_pin.sampled.sensor_noise import NOISE_KEYS, LoopNoise, loop_noise
from asmc_pin.sampled.workspace_worst import Workspace, workspace_of
from asmc_pin.words.shown import Cells, Shown
from asmc_pin.words.text import printable
from asmc_pin.words.units import check_delay, check_period

if TYPE_CHECKING:
    from asmc_pin.arms import Arm


@dataclass(frozen=True, repr=False)
class StabilityReport(Shown):
    """What was found about a sampled loop; by search, so that "stable" means that no configuration tried is unstable.

    Attributes:
        about: What the verdict is about: arm, armature, payload, locked joints, box.
        gravity: Acceleration of gravity in the base frame, shape (3,), m/s².
        loop: Gains and timing.
        spectral_radius: Largest one found over the workspace, M held at M(q), no other force.
        worst_q: Where, shape (nv,), rad.
        rest_radius: The same for the linearisation about rest, where gravity acts as a spring of either sign.
        rest_q: Where, shape (nv,), rad.
        ratios: Smallest and largest eigenvalue of M⁻¹M̄ found.
        limits: Largest gains and period, and margins; None if not asked for.
        remedy: What to do where it is unstable, the same as before a run; empty where it is stable.
        configurations: How many were tried.
        seconds: Wall time.
        noise: What the sensors' noise makes of torque and error; None if no noise was named.
    """

    about: Premises
    gravity: Array
    loop: SampledLoop
    spectral_radius: float
    worst_q: Array
    rest_radius: float
    rest_q: Array
    ratios: tuple[float, float]
    limits: LoopLimits | None
    configurations: int
    seconds: float
    remedy: str = ""
    noise: LoopNoise | None = None

    @property
    def arm(self) -> str:
        """Name of the arm."""
        return self.about.arm

    @property
    def joints(self) -> tuple[str, ...]:
        """Its moving joints, base first."""
        return self.about.joints

    @property
    def stable(self) -> bool:
        """Whether every frozen loop that was tried is stable, with and without gravity's stiffness."""
        return self.spectral_radius < 1.0 and self.rest_radius < 1.0

    @property
    def verdict(self) -> Literal["stable", "unstable"]:
        """The verdict in a word."""
        return "stable" if self.stable else "unstable"

    @property
    def decay_rate(self) -> float:
        """Slowest decay of the worst loop, −ln ρ / L, 1/s; negative where it grows."""
        return -math.log(self.spectral_radius) / self.loop.period

    def to_json_dict(self) -> dict[str, Any]:
        """Every figure by name; undefined ones are None."""
        loop, limits = self.loop, self.limits
        result: dict[str, Any] = {
            **self.about.to_json_dict(),
            "gravity": self.gravity.tolist(),
            "mbar": loop.mbar.tolist(),
            "ks": loop.ks.tolist(),
            "beta": _scalar(loop.beta),
            "period": loop.period,
            "acceleration": loop.acceleration,
            "filter_hz": loop.filter_hz,
            "delay": loop.delay,
            "velocity": loop.velocity,
            "velocity_filter_hz": loop.velocity_filter_hz,
            "reading_delay": loop.reading_delay,
            "pairing": "mean" if loop.averages_torque else "last",
            **(dict.fromkeys(NOISE_KEYS) if self.noise is None else self.noise.to_json_dict()),
            "verdict": self.verdict,
            "kind": "sampled",
            "spectral_radius": self.spectral_radius,
            "worst_q": self.worst_q.tolist(),
            "decay_rate": self.decay_rate,
            "rest_spectral_radius": self.rest_radius,
            "rest_worst_q": self.rest_q.tolist(),
            "mbar_ratio_min": self.ratios[0],
            "mbar_ratio_max": self.ratios[1],
            "configurations": self.configurations,
            "seconds": self.seconds,
            "remedy": self.remedy or None,
        }
        if limits is not None:
            result |= {
                "gain_scale_max": _finite(limits.gain_scale),
                "beta_max": _spread(loop.beta, limits.beta_scale),
                "ks_scale_max": _finite(limits.ks_scale),
                "ks_max": _spread(loop.ks, limits.ks_scale),
                "period_max": _finite(limits.period),
                "gain_margin": [_finite(end) for end in limits.gain_margin],
                "gain_margin_db": [_finite(end) for end in limits.gain_margin_db],
                "delay_margin_periods": _finite(limits.delay_margin),
                "delay_margin_seconds": _finite(limits.delay_margin * loop.period),
            }
        return result

    def lines(self) -> list[str]:
        """The report in plain words: the verdict, what it is about, and a line per finding."""
        text = [
            f"{self.about.title}: the sampled loop is {self.verdict.upper()} ({self.configurations} configurations "
            "searched)",
            *self.about.lines(),
            f"Gravity: ({', '.join(f'{x:g}' for x in self.gravity)}) m/s² in the base frame",
            f"Loop: {self.loop.words()}",
            f"spectral radius {self.spectral_radius:.6f}, worst at q = {_angles(self.worst_q)} rad",
            f"slowest decay there {self.decay_rate:.3g} 1/s; eigenvalues of M⁻¹M̄ over the workspace "
            f"{self.ratios[0]:.4g} to {self.ratios[1]:.4g}",
            f"at rest under gravity: {self.rest_radius:.6f}, worst at q = {_angles(self.rest_q)} rad",
        ]
        if self.rest_radius >= 1.0 > self.spectral_radius:
            text.append("unstable through gravity: the arm falls faster than the torque estimate follows")
        if self.remedy:
            text.append(self.remedy)
        if self.limits is not None:
            text += _limit_lines(self.loop, self.limits)
        return text + ([] if self.noise is None else self.noise.lines(self.loop))

    def table(self) -> Cells:
        """The loop and the worst configurations, joint by joint."""
        unit = "rad or m" if any(self.about.slides) else "rad"
        columns = (self.loop.mbar, self.loop.ks, self.loop.beta)
        return ["joint", "m̄ kg·m²", "k_s 1/s", "β 1/s", f"worst q {unit}", "at rest"], [
            [printable(name), *(f"{value:.6g}" for value in values), f"{q:+.4f}", f"{rest:+.4f}"]
            for name, *values, q, rest in zip(self.joints, *columns, self.worst_q, self.rest_q, strict=True)
        ]


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
    viscous: ArrayLike | None = None,
    box: BoxLike = None,
    samples: int = 2048,
    seed: int = 0,
    limits: bool = True,
) -> StabilityReport:
    """Analyse the sampled loop (7) on an arm, frozen over its workspace.

    Args:
        arm: The arm.
        mbar: Diagonal of M̄, a scalar or nv values, kg·m².
        ks: Diagonal of K_s, a scalar or nv values, 1/s.
        beta: β, 1/s.
        period: Control period L, s.
        acceleration: Estimate of q̈(t−L): "velocity" or "position".
        filter_hz: Low-pass on it, Hz.
        delay: Transport delay of the torque, periods; see docs/stability.md.
        sensor: How v is made, and the noise of what the drives report; see `loop_sensor`. v is measured, and nothing is
            off, by default.
        pairing: Torque that goes with the estimate; see `SampledLoop`.
        viscous: Viscous friction that is counted on, a scalar or nv values, N·m·s/rad; none by default, to be careful.
        box: Joint box; the arm's own by default.
        samples: Number of configurations before the local search.
        seed: Of the samples.
        limits: Whether to look for largest gains and margins too, which takes most of the time.

    Raises:
        ParameterError: a value has a wrong size, sign, or is not finite.
        ArmError: the box is not finite.
    """
    clock = Clock()
    timing = {} if sensor is None else sensor.timing
    loop = loop_for(
        arm, mbar, ks, beta, period, acceleration=acceleration, filter_hz=filter_hz, delay=delay, pairing=pairing,
        **timing,
    )  # fmt: skip
    friction = None if viscous is None else _viscous(viscous, arm.nv)
    workspace = workspace_of(arm, asked_box(arm, box), samples=samples, seed=seed, viscous=friction)
    radius, q, tried = workspace.worst(loop)
    rest_radius, rest_q, more = at_rest(workspace, loop, samples=samples, seed=seed)
    (low, _), (high, _) = workspace.ratio_range(loop.mbar)
    stable = radius < 1.0 and rest_radius < 1.0
    return StabilityReport(
        about=premises_of([arm], [ends_of(workspace.box)], (arm.armature, arm.armature)),
        gravity=arm.gravity_vector,
        loop=loop,
        spectral_radius=radius,
        worst_q=q,
        rest_radius=rest_radius,
        rest_q=rest_q,
        ratios=(low, high),
        limits=limits_of(workspace, loop, q) if limits else None,
        configurations=tried + more,
        remedy="" if stable else remedy([arm], loop, viscous=friction, box=box),
        seconds=clock.seconds(),
        noise=noise_at_rest(workspace, loop, sensor),
    )


def noise_at_rest(workspace: Workspace, loop: SampledLoop, sensor: LoopSensor | None) -> LoopNoise | None:
    """The sensors' noise in the loop, with gravity if it acts; None if nothing that they report is off."""
    if sensor is None or not sensor.noisy:
        return None
    arm, box, count = workspace.arm, (workspace.box.lower, workspace.box.upper), len(workspace.q)
    heavy = bool(np.any(arm.gravity_vector))
    return loop_noise(workspace_of(arm, box, samples=count, gravity=heavy, viscous=workspace.viscous), loop, sensor)


def loop_for(arm: Arm, mbar: ArrayLike, ks: ArrayLike, beta: ArrayLike, period: float, **timing: Any) -> SampledLoop:
    """The loop with M̄ spread over the arm's joints.

    Raises:
        ParameterError: as of `SampledLoop`, or a period or delay that is hardly meant in its unit.
    """
    loop = SampledLoop(positive_per_joint("mbar", mbar, arm.nv, "kg·m²"), ks, beta, period, **timing)  # type: ignore[arg-type]
    check_period(loop.period)
    check_delay(loop.delay, loop.period)
    return loop


def at_rest(workspace: Workspace, loop: SampledLoop, *, samples: int, seed: int) -> tuple[float, Array, int]:
    """Largest radius about rest under gravity, where, and how many configurations were tried for it."""
    arm, box = workspace.arm, (workspace.box.lower, workspace.box.upper)
    if not np.any(arm.gravity_vector):
        radius, q, _ = workspace.worst(loop)
        return radius, q, 0
    return workspace_of(arm, box, samples=samples, seed=seed, gravity=True, viscous=workspace.viscous).worst(loop)


def _viscous(value: ArrayLike, nv: int) -> Array:
    try:
        friction = np.array(np.broadcast_to(np.asarray(value, dtype=np.float64), (nv,)))
    except (TypeError, ValueError):
        raise ParameterError("viscous", f"got {value!r}; expected a number or {nv} of them, in N·m·s/rad") from None
    if not (np.isfinite(friction).all() and (friction >= 0.0).all()):
        raise ParameterError("viscous", f"got {friction.tolist()}; every value must be finite and 0 or more")
    return friction


def _limit_lines(loop: SampledLoop, limits: LoopLimits) -> list[str]:
    if limits.gain_scale == 0.0:
        return []
    low, high = limits.gain_margin
    beta = _spread(loop.beta, limits.beta_scale)
    margins = (
        "no margins: it is unstable as it is"
        if math.isnan(low)
        else f"margins: torque gain {low:.3g} to {high:.3g}, extra delay {limits.delay_margin:.3g} periods "
        f"({1e3 * limits.delay_margin * loop.period:.3g} ms)"
    )
    alone = f", β alone to {beta:.4g}, K_s alone by {_times(limits.ks_scale)}" if isinstance(beta, float) else ""
    return [
        f"by inertia alone: at L = {loop.period:g} s, β and K_s may grow by {_times(limits.gain_scale)}{alone}",
        f"by inertia alone, with these gains: L may be up to {limits.period:.4g} s",
        margins,
    ]


def _angles(q: Array) -> str:
    return "(" + ", ".join(f"{angle:.3f}" for angle in q) + ")"


def _times(scale: float) -> str:
    return "any factor" if math.isinf(scale) else f"a factor of {scale:.4g}"


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _scalar(values: Array) -> float | list[float]:
    return float(values[0]) if bool(np.all(values == values[0])) else values.tolist()


def _spread(values: Array, scale: float) -> float | list[float] | None:
    return _scalar(values * scale) if math.isfinite(scale) else None
