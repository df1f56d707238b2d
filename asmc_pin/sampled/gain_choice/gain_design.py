"""What `design --gains` says: gains, the margins that they keep, and what they are worth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.hypotheses import Premises
from asmc_pin.sampled.gain_choice.gain_search import USEFUL, Margins
from asmc_pin.sampled.sampled_loop import SampledLoop
from asmc_pin.sampled.stability_report import StabilityReport, margin_words
from asmc_pin.words.shown import Shown
from asmc_pin.words.text import rounded_up

_KEPT = ("acceleration", "filter_hz", "delay", "spectral_radius", "rest_spectral_radius", "decay_rate")
_MARGINS = ("gain_margin", "gain_margin_db", "delay_margin_periods", "delay_margin_seconds", "period_max")


@dataclass(frozen=True, eq=False)
class ExpectedErrors:
    """The tracking error that gains promise.

    Attributes:
        speed: Joint speed that `drift` is for, shape (nv,), rad/s.
        drift: Bound of the error while gravity drifts as at that speed of all joints, worst found, shape (nv,), rad.
        coulomb: Coulomb friction that the next two are for, shape (nv,), N·m.
        reversal_peak: Largest |e| after a joint's own friction reverses, worst of a few configurations, (nv,), rad.
        reversal_rms: RMS error if every joint reverses once a second, likewise, shape (nv,), rad.
    """

    speed: Array
    drift: Array
    coulomb: Array
    reversal_peak: Array
    reversal_rms: Array

    def lines(self) -> list[str]:
        """In plain words."""
        return [
            f"error while gravity drifts, joints at {_list(self.speed)} rad/s: to {_list(np.rad2deg(self.drift))} deg",
            f"error after friction of {_list(self.coulomb)} N·m reverses: peak "
            f"{_list(np.rad2deg(self.reversal_peak))} deg, RMS at one reversal a second "
            f"{_list(np.rad2deg(self.reversal_rms))} deg",
        ]


@dataclass(frozen=True, repr=False)
class GainDesign(Shown):
    """Gains with margins, or why there are none.

    Attributes:
        about: What they are for: arm, armature, payload, locked joints, box.
        unit: M̄ at scale 1, and the timing; its gains mean nothing.
        asked: The margins asked for.
        report: The stability and the margins of the loop that was found; None where no gains are stable.
        expected: The errors that it promises; None likewise.
        why: What stands against the margins asked for, or against a useful k_s; a sentence each.
        armature: What each joint's armature would have to grow by for k_s of at least `USEFUL` with the margins asked
            for, shape (nv,), kg·m²; None where that is not needed, or not known.
    """

    about: Premises
    unit: SampledLoop
    asked: Margins
    report: StabilityReport | None
    expected: ExpectedErrors | None
    why: tuple[str, ...]
    armature: Array | None

    @property
    def loop(self) -> SampledLoop:
        """Gains and timing that were found.

        Raises:
            ValueError: there are none.
        """
        if self.report is None:
            raise ValueError("no gains are stable; `lines` says why")
        return self.report.loop

    @property
    def mbar(self) -> Array:
        """Diagonal of M̄ to use, shape (nv,), kg·m²."""
        return self.unit.mbar if self.report is None else self.report.loop.mbar

    @property
    def mbar_scale(self) -> float:
        """What the given M̄ is multiplied by; at most 1, where both conditions on M̄ go on holding."""
        return float(self.mbar[0] / self.unit.mbar[0])

    @property
    def reached(self) -> Margins | None:
        """The margins found; None without gains."""
        limits = None if self.report is None else self.report.limits
        return None if limits is None else Margins(limits.gain_margin, limits.delay_margin)

    @property
    def met(self) -> bool:
        """Whether they are those asked for."""
        return self.reached is not None and self.reached.cover(self.asked)

    @property
    def useful(self) -> bool:
        """Whether k_s is at least `USEFUL`."""
        return self.report is not None and bool(self.loop.ks.min() >= USEFUL)

    def to_json_dict(self) -> dict[str, Any]:
        """Every figure by name; undefined ones are None."""
        stable = {} if self.report is None else self.report.to_json_dict()
        errors = self.expected
        content: dict[str, Any] = {
            "mbar": self.mbar.tolist(),
            "mbar_scale": self.mbar_scale,
            "beta": None if self.report is None else float(self.loop.beta[0]),
            "ks": None if self.report is None else self.loop.ks.tolist(),
            "period": self.unit.period,
            **{name: stable.get(name) for name in (*_KEPT, *_MARGINS)},
            "asked": {"gain_margin": list(self.asked.gain), "delay_margin_periods": self.asked.delay},
            "met": self.met,
            "useful": self.useful,
            "why": list(self.why),
            "armature_wanted": None if self.armature is None else self.armature.tolist(),
        }
        for name, key in (("speed", "speed"), ("drift", "drift_error"), ("coulomb", "coulomb")):
            content[key] = None if errors is None else getattr(errors, name).tolist()
        for name in ("reversal_peak", "reversal_rms"):
            content[name] = None if errors is None else getattr(errors, name).tolist()
        return content

    def lines(self) -> list[str]:
        """The design in plain words, a line per finding."""
        title = f"{self.about.title}, L = {self.unit.period:g} s"
        low, high = self.asked.gain
        asked = f"torque gain {low:.4g} to {high:.4g}, extra delay {self.asked.delay:.4g} periods"
        mbar = "M̄ = " + ",".join(f"{value:.17g}" for value in self.mbar)
        if self.report is None or self.reached is None or self.expected is None:
            return [
                f"{title}: no β and k_s are stable, with this M̄ or less of it",
                mbar,
                *self.why,
                *self._armature_line(),
            ]
        reached = margin_words(self.reached.gain, self.reached.delay, self.unit.period)
        said = [
            f"{title}: β = {self.loop.beta[0]:.6g} 1/s, k_s = {self.loop.ks[0]:.6g} 1/s, and this M̄, which is "
            f"{self.mbar_scale:.6g} times the one above and so keeps its condition:"
            if self.mbar_scale < 1.0
            else f"{title}: β = {self.loop.beta[0]:.6g} 1/s, k_s = {self.loop.ks[0]:.6g} 1/s, and this M̄:",
            mbar,
            f"margins, at rest under gravity and of the inertia alone, where searched: {reached}",
        ]
        if not self.met:
            said.append(f"the margins asked for cannot be had: {asked}")
        if not self.useful:
            constant = rounded_up(1.0 / float(self.loop.ks.min()), 3)
            said.append(f"of no use: errors die with a time constant of 1/k_s = {constant} s")
        said += self.why
        return [*said, *self._armature_line(), *self.expected.lines()]

    def _armature_line(self) -> list[str]:
        if self.met and self.useful:
            return []
        if self.armature is None:
            return [f"no armature that was tried would allow these margins with k_s of {USEFUL:g} 1/s"]
        return [
            f"armature of {_list(self.armature)} kg·m² more would allow the margins asked for with k_s of at least "
            f"{USEFUL:g} 1/s, where searched"
        ]


def _list(values: Array) -> str:
    return "(" + ", ".join(f"{value:.3g}" if abs(value) > 1e-9 else "0" for value in values) + ")"
