"""What `asmc-pin stability` says: whether the sampled loop is stable over the workspace, and with what margins."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.hypotheses import Premises
from asmc_pin.controllers.law_registry import law_name
from asmc_pin.sampled.loop_limits import DELAY_SPAN, LoopLimits
from asmc_pin.sampled.noise.sensor_noise import NOISE_KEYS, LoopNoise
from asmc_pin.sampled.sampled_loop import SampledLoop, law_settings
from asmc_pin.words.joint_units import column_cells, column_head, listed_with_units
from asmc_pin.words.shown import Cells, Shown
from asmc_pin.words.text import counted, printable, rounded_down, rounded_up

if TYPE_CHECKING:
    from asmc_pin.sampled.proof.loop_proof import LoopProof


@dataclass(frozen=True, eq=False)
class WorstFound:
    """The worst configuration of a loop that a search found.

    Attributes:
        radius: Spectral radius.
        q: Where, shape (nv,), rad.
        where: Which payload, armature and locked joints of the ranges, as the keys of ``--json``.
        said: The same for a person to read; empty without ranges.
    """

    radius: float
    q: Array
    where: dict[str, Any]
    said: str


@dataclass(frozen=True, repr=False)
class StabilityReport(Shown):
    """What was found about a sampled loop; by search, so that "stable" means that nothing tried is unstable.

    Attributes:
        about: What the verdict is about: arm, armature, payload, locked joints, box.
        gravity: Acceleration of gravity in the base frame, shape (3,), m/s².
        loop: Gains and timing.
        bare: The worst with M held at M(q), no other force.
        rest: The worst of the linearisation about rest, where gravity acts as a spring of either sign.
        ratios: Smallest and largest eigenvalue of M⁻¹M̄ found.
        limits: Largest gains and period, and margins; None if not asked for.
        remedy: What would make an unstable loop stable; empty for a stable one, or if limits were not asked for.
        configurations: How many were tried for the verdict.
        seconds: Wall time.
        proof: What is proven of it; None if not asked for.
        noise: What the sensors' noise makes of torque and error; None if no noise was named.
    """

    about: Premises
    gravity: Array
    loop: SampledLoop
    bare: WorstFound
    rest: WorstFound
    ratios: tuple[float, float]
    limits: LoopLimits | None
    remedy: str
    configurations: int
    seconds: float
    proof: LoopProof | None = None
    noise: LoopNoise | None = None

    @property
    def spectral_radius(self) -> float:
        """Largest one found with M alone."""
        return self.bare.radius

    @property
    def worst_q(self) -> Array:
        """Where, shape (nv,), rad."""
        return self.bare.q

    @property
    def rest_radius(self) -> float:
        """Largest one found at rest under gravity."""
        return self.rest.radius

    @property
    def rest_q(self) -> Array:
        """Where, shape (nv,), rad."""
        return self.rest.q

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
        refuted = self.proof is not None and self.proof.verdict == "unstable"
        return self.spectral_radius < 1.0 and self.rest_radius < 1.0 and not refuted

    @property
    def kind(self) -> Literal["searched", "certified"]:
        """``certified`` where a proof decides about the loop without gravity; of gravity `LoopProof.gravity` says."""
        decided = self.proof is not None and self.proof.verdict != "undecided"
        return "certified" if decided else "searched"

    @property
    def verdict(self) -> Literal["stable", "unstable"]:
        """The verdict in a word; "stable" where searched."""
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
            "law": None if loop.law is None else {"name": law_name(loop.law), **law_settings(loop.law)},
            **(dict.fromkeys(NOISE_KEYS) if self.noise is None else self.noise.to_json_dict()),
            "verdict": self.verdict,
            "kind": self.kind,
            "spectral_radius": self.spectral_radius,
            "worst_q": self.worst_q.tolist(),
            "decay_rate": self.decay_rate,
            "rest_spectral_radius": self.rest_radius,
            "rest_worst_q": self.rest_q.tolist(),
            **self.bare.where,
            **{f"rest_{name}": value for name, value in self.rest.where.items()},
            "mbar_ratio_min": self.ratios[0],
            "mbar_ratio_max": self.ratios[1],
            "configurations": self.configurations,
            "seconds": self.seconds,
        }
        if self.proof is not None:
            result["proof"] = self.proof.to_json_dict()
        if limits is not None:
            result |= {
                "gain_scale_min": limits.gain_range[0],
                "gain_scale_max": _finite(limits.gain_scale),
                "beta_max": _spread(loop.beta, limits.beta_scale),
                "ks_scale_max": _finite(limits.ks_scale),
                "ks_max": _spread(loop.ks, limits.ks_scale),
                "period_max": _finite(limits.period),
                "gain_margin": [_finite(end) for end in limits.gain_margin],
                "gain_margin_db": [_finite(end) for end in limits.gain_margin_db],
                "delay_margin_periods": _finite(limits.delay_margin),
                "delay_margin_seconds": _finite(limits.delay_margin * loop.period),
                "delay_searched_periods": DELAY_SPAN,
                "remedy": self.remedy or None,
            }
        return result

    def lines(self) -> list[str]:
        """The report in plain words: the verdict, what it is about, and a line per finding."""
        found = "stable where searched" if self.stable else "UNSTABLE"
        worth = (
            "what is proven stands below"
            if self.proof is not None and self.proof.verdict == "stable"
            else "a search refutes, it proves nothing"
        )
        tried = counted(self.configurations, "configuration")
        text = [
            f"{self.about.title}: the sampled loop is {found} ({tried}; {worth})",
            *self.about.lines(),
            f"Gravity: ({', '.join(f'{x:g}' for x in self.gravity)}) m/s² in the base frame",
            f"Loop: {self.loop.words(self.about.slides)}",
            f"spectral radius {self.spectral_radius:.6f}, worst at q = {self._place(self.worst_q)}{self.bare.said}",
            f"slowest decay there {self.decay_rate:.3g} 1/s; eigenvalues of M⁻¹M̄ over the workspace "
            f"{self.ratios[0]:.4g} to {self.ratios[1]:.4g}",
            f"at rest under gravity: {self.rest_radius:.6f}, worst at q = {self._place(self.rest_q)}{self.rest.said}",
        ]
        if self.rest_radius >= 1.0 > self.spectral_radius:
            text.append("unstable through gravity: the arm falls faster than the torque estimate follows")
        if self.proof is not None:
            text += self.proof.lines()
        if self.limits is not None:
            text += _limit_lines(self.loop, self.limits) if self.stable else [f"remedy: {self.remedy}"]
        return text + ([] if self.noise is None else self.noise.lines(self.loop))

    def table(self) -> Cells:
        """The loop and the worst configurations, joint by joint."""
        slides = self.about.slides
        mbar = column_cells([f"{value:.6g}" for value in self.loop.mbar], "inertia", slides)
        gains = ([f"{value:.6g}" for value in values] for values in (self.loop.ks, self.loop.beta))
        places = (
            column_cells([f"{q:+.4f}" for q in values], "place", slides) for values in (self.worst_q, self.rest_q)
        )
        rows = zip(map(printable, self.joints), mbar, *gains, *places, strict=True)
        heads = ["k_s 1/s", "β 1/s", column_head("worst q", "place", slides), "at rest"]
        return ["joint", column_head("m̄", "inertia", slides), *heads], [list(row) for row in rows]

    def _place(self, q: Array) -> str:
        return listed_with_units([angle_text(x) for x in q], "place", self.about.slides)


def _limit_lines(loop: SampledLoop, limits: LoopLimits) -> list[str]:
    beta = _spread(loop.beta, limits.beta_scale)
    low, high = limits.gain_range
    alone = (
        f", β alone to {rounded_down(beta, 4)}, K_s alone by {_times(limits.ks_scale)}"
        if isinstance(beta, float)
        else ""
    )
    down = f"down to {rounded_up(low, 4)} times" if low > 0.0 else "down to nothing"
    return [
        f"where searched, at L = {loop.period:g} s, β and K_s may grow together by {_times(high)}{alone}, and shrink "
        f"together {down}",
        f"where searched, with these gains L may be up to {rounded_down(limits.period, 4)} s",
        f"margins, where searched: {margin_words(limits.gain_margin, limits.delay_margin, loop.period)}",
    ]


def margin_words(gain: tuple[float, float], delay: float, period: float) -> str:
    """Margins for a person to read, rounded to the safe side."""
    low, high = gain
    least = rounded_up(low, 3) if low > 0.0 else "any fraction"
    most = rounded_down(high, 3) if math.isfinite(high) else "any factor"
    return f"torque gain {least} to {most}, extra delay {delay_words(delay, period)}"


def delay_words(delay: float, period: float) -> str:
    """A delay margin for a person to read, rounded to the safe side."""
    if math.isinf(delay):
        return f"more than {DELAY_SPAN:g} periods (where the search ends)"
    periods = rounded_down(delay, 3) if delay > 0.0 else "0"
    return f"{periods} periods ({1e3 * float(periods) * period:.3g} ms)"


def angles(q: Array) -> str:
    """Values joint by joint, in a sentence."""
    return f"({', '.join(angle_text(angle) for angle in q)})"


def angle_text(angle: float) -> str:
    """A value of a joint, in a sentence."""
    return f"{angle:.3f}" if angle == 0.0 or abs(angle) >= 0.01 else f"{angle:.3g}"


def _times(scale: float) -> str:
    return "any factor" if math.isinf(scale) else f"a factor of {rounded_down(scale, 4)}"


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _scalar(values: Array) -> float | list[float]:
    return float(values[0]) if bool(np.all(values == values[0])) else values.tolist()


def _spread(values: Array, scale: float) -> float | list[float] | None:
    return _scalar(values * scale) if math.isfinite(scale) else None
