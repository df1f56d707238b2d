"""From M̄ to gains: β and K_s with stated margins, the errors to expect, and warnings before a run."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.condition.domain.joint_box import BoxLike, asked_box
from asmc_pin.errors import ParameterError
from asmc_pin.sampled.error_prediction import drift_error, step_response
from asmc_pin.sampled.linear_map import modal_radius
from asmc_pin.sampled.loop_limits import modes_of
from asmc_pin.sampled.sampled_loop import Acceleration, SampledLoop
from asmc_pin.sampled.stability_report import StabilityReport, loop_for, stability
from asmc_pin.sampled.workspace_worst import Workspace, gravity_stiffness, workspace_of
from asmc_pin.words.shown import Shown
from asmc_pin.words.units import check_delay

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

_SCALES = np.geomspace(0.05, 1.0, 15)


@dataclass(frozen=True, repr=False)
class GainDesign(Shown):
    """Gains with margins, and what tracking error they promise.

    Attributes:
        loop: M̄ (the given one times `mbar_scale`), K_s = βI, β and timing.
        mbar_scale: At most 1. Both conditions on M̄ go on holding when it is scaled down.
        report: The loop's stability and its margins.
        speed: Joint speed that `drift` is for, shape (nv,), rad/s.
        drift: Bound of the error while gravity drifts as at that speed of all joints, worst found, shape (nv,), rad.
        coulomb: Coulomb friction that the next two are for, shape (nv,), N·m.
        reversal_peak: Largest |e| after a joint's own friction reverses, worst of a few configurations, (nv,), rad.
        reversal_rms: RMS error if every joint reverses once a second, likewise, shape (nv,), rad.
    """

    loop: SampledLoop
    mbar_scale: float
    report: StabilityReport
    speed: Array
    drift: Array
    coulomb: Array
    reversal_peak: Array
    reversal_rms: Array

    def to_json_dict(self) -> dict[str, Any]:
        """Every figure by name; undefined ones are None."""
        stable = self.report.to_json_dict()
        kept = ("period", "acceleration", "filter_hz", "delay", "spectral_radius", "rest_spectral_radius", "decay_rate")
        margins = ("gain_margin", "gain_margin_db", "delay_margin_periods", "delay_margin_seconds", "period_max")
        return {
            "mbar": self.loop.mbar.tolist(),
            "mbar_scale": self.mbar_scale,
            "beta": float(self.loop.beta[0]),
            "ks": self.loop.ks.tolist(),
            **{name: stable[name] for name in (*kept, *margins)},
            "speed": self.speed.tolist(),
            "drift_error": self.drift.tolist(),
            "coulomb": self.coulomb.tolist(),
            "reversal_peak": self.reversal_peak.tolist(),
            "reversal_rms": self.reversal_rms.tolist(),
        }

    def lines(self) -> list[str]:
        """The design in plain words, a line per finding."""
        limits = self.report.limits
        assert limits is not None
        low, high = limits.gain_margin
        return [
            f"{self.report.about.title}, L = {self.loop.period:g} s: β = k_s = {self.loop.beta[0]:.4g} 1/s, "
            f"M̄ times {self.mbar_scale:.3g}",
            "M̄ = " + ",".join(f"{value:.17g}" for value in self.loop.mbar),
            f"margins: torque gain {low:.3g} to {high:.3g}, extra delay {limits.delay_margin:.3g} periods",
            *(
                []
                if self.report.stable
                else ["BUT UNSTABLE at rest under gravity: choose a larger M̄ or smaller margins"]
            ),
            f"error while gravity drifts, joints at {_list(self.speed)} rad/s: to {_list(np.rad2deg(self.drift))} deg",
            f"error after friction of {_list(self.coulomb)} N·m reverses: peak "
            f"{_list(np.rad2deg(self.reversal_peak))} deg, RMS at one reversal a second "
            f"{_list(np.rad2deg(self.reversal_rms))} deg",
        ]


def suggest_gains(
    arm: Arm,
    mbar: ArrayLike,
    period: float,
    *,
    acceleration: Acceleration = "velocity",
    filter_hz: float | None = None,
    delay: float = 0.0,
    gain_margin: float = 2.0,
    delay_margin: float = 1.0,
    scale_mbar: bool = True,
    speed: ArrayLike = 1.0,
    coulomb: ArrayLike | None = None,
    box: BoxLike = None,
    samples: int = 2048,
    seed: int = 0,
) -> GainDesign:
    """The stiffest gains β = k_s (a double pole of (8)) that keep the asked margins over the workspace.

    A drifting load leaves e = (1 + d) L ḣ/(m̄ β k_s), so m̄ β k_s is made as large as possible, over the gains and,
    unless told otherwise, over M̄ scaled down: an M̄ near the end of its condition has no gain margin left.

    Args:
        arm: The arm.
        mbar: Diagonal of M̄, a scalar or nv values, kg·m²; one that `design` found, say.
        period: Control period L, s.
        acceleration: Estimate of q̈(t−L).
        filter_hz: Low-pass on it, Hz.
        delay: Transport delay, periods.
        gain_margin: Factor above 1 by which the torque gain may be off, either way.
        delay_margin: Delay that may come on top, periods, 0 or more.
        scale_mbar: Whether M̄ may be scaled down.
        speed: Joint speeds for the drift prediction, a scalar or nv values, rad/s.
        coulomb: Coulomb friction for the reversal prediction, a scalar or nv values, N·m; the URDF's by default, or
            1 for every joint where it declares none.
        box: Joint box; the arm's own by default.
        samples: Number of configurations searched.
        seed: Of the samples.

    Returns:
        Gains, margins and predictions.

    Raises:
        ParameterError: a value cannot be used, or no gains have the margins; the message says what to change.
    """
    loop = loop_for(arm, mbar, 1.0, 1.0, period, acceleration=acceleration, filter_hz=filter_hz, delay=delay)
    _check("gain_margin", gain_margin, 1.0)
    _check("delay_margin", delay_margin, 0.0)
    check_delay(delay_margin, period, "delay_margin")
    workspace = workspace_of(arm, asked_box(arm, box), samples=samples, seed=seed)
    ratios = modes_of(workspace, loop.mbar, 24).ratios
    scale, gain = _stiffest(ratios, loop, gain_margin, delay_margin, _SCALES if scale_mbar else np.ones(1))
    if gain == 0.0:
        raise ParameterError(
            "mbar" if not scale_mbar else "gain_margin",
            f"no gains keep a torque gain margin of {gain_margin:g} and {delay_margin:g} periods of delay: M⁻¹M̄ has "
            f"eigenvalues from {ratios.min():.3g} to {ratios.max():.3g}, and {gain_margin:g} times the largest "
            "must stay below 2; "
            + ("let M̄ be scaled down, or ask for smaller margins" if not scale_mbar else "ask for smaller margins"),
        )
    chosen = loop.scaled(mbar=scale, ks=gain, beta=gain)
    report = stability(
        arm, chosen.mbar, chosen.ks, chosen.beta, period, acceleration=acceleration, filter_hz=filter_hz, delay=delay,
        box=box, samples=samples, seed=seed,
    )  # fmt: skip
    if coulomb is None:
        coulomb = arm.friction if arm.friction.any() else 1.0
    return _with_predictions(arm, chosen, scale, report, workspace, speed, coulomb)


def _stiffest(
    ratios: Array, loop: SampledLoop, gain_margin: float, delay_margin: float, scales: Array
) -> tuple[float, float]:
    """The scale of M̄ and the gain β = k_s that make scale·gain² largest; gain 0 if no gain keeps the margins."""

    def best(scale: float) -> float:
        return _largest_gain(ratios * scale, loop.mode, gain_margin, delay_margin)

    gains = np.array([best(float(scale)) for scale in scales])
    first = int(np.argmax(scales * gains**2))
    scale, gain = float(scales[first]), float(gains[first])
    # Around the best of the coarse scales, finer.
    for finer in np.geomspace(scales[max(first - 1, 0)], scales[min(first + 1, len(scales) - 1)], 9)[1:-1]:
        other = best(float(finer))
        if finer * other**2 > scale * gain**2:
            scale, gain = float(finer), other
    return scale, gain


def _largest_gain(ratios: Array, mode: SampledLoop, gain_margin: float, delay_margin: float) -> float:
    """The largest β = k_s at which all modes keep the margins, by bisection; 0 if none does."""
    spread = np.multiply.outer(np.geomspace(1.0 / gain_margin, gain_margin, 5), ratios)

    def keeps(gain: float) -> bool:
        loop = replace(mode, ks=np.full(1, gain), beta=np.full(1, gain))
        if modal_radius(spread, loop).max() >= 1.0:
            return False
        later = (replace(loop, delay=loop.delay + share * delay_margin) for share in (0.25, 0.5, 0.75, 1.0))
        return delay_margin == 0.0 or all(modal_radius(ratios, other).max() < 1.0 for other in later)

    low, high = 0.0, 1e-3 / mode.period
    while keeps(high):  # comes to an end: no mode is stable beyond (β + k_s) L = 4/a
        low, high = high, 2.0 * high
    if low == 0.0:
        return 0.0
    while high / low > 1.0005:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if keeps(middle) else (low, middle)
    return low


def _with_predictions(
    arm: Arm,
    loop: SampledLoop,
    scale: float,
    report: StabilityReport,
    workspace: Workspace,
    speed: ArrayLike,
    coulomb: ArrayLike,
) -> GainDesign:
    speeds, friction = (np.array(np.broadcast_to(np.asarray(x, dtype=np.float64), (arm.nv,))) for x in (speed, coulomb))
    drift = _largest_drift(arm, workspace, speeds)
    low, high = workspace.ratio_range(loop.mbar)
    q = np.stack([report.worst_q, low[1], high[1], *workspace.q[:5]])
    response = step_response(arm.mass_matrix(q), loop, 2.0 * friction)
    return GainDesign(
        loop=loop,
        mbar_scale=scale,
        report=report,
        speed=speeds,
        drift=drift_error(loop, drift),
        coulomb=friction,
        reversal_peak=np.diagonal(response.peak, axis1=-2, axis2=-1).max(axis=0),
        reversal_rms=response.rms(1.0).max(axis=0),
    )


def _largest_drift(arm: Arm, workspace: Workspace, speeds: Array) -> Array:
    """Largest rate at which gravity's torque on each joint drifts, anywhere in the workspace, shape (nv,), N·m/s."""
    heavy = workspace_of(arm, (workspace.box.lower, workspace.box.upper), samples=len(workspace.q), gravity=True)

    def rates(q: Array) -> Array:
        return np.asarray(np.abs(gravity_stiffness(arm, q)) @ speeds)

    def largest(joint: int) -> float:
        return heavy.maximise(lambda q: rates(q)[:, joint], at_samples[:, joint])[0]

    at_samples = rates(heavy.q)
    return np.array([largest(joint) for joint in range(arm.nv)])


def _check(name: str, value: float, least: float) -> None:
    if not (isinstance(value, (int, float, np.integer, np.floating)) and math.isfinite(value) and value >= least):
        raise ParameterError(name, f"got {value!r}; expected a number of at least {least:g}")


def _list(values: Array) -> str:
    return "(" + ", ".join(f"{value:.3g}" if abs(value) > 1e-9 else "0" for value in values) + ")"
