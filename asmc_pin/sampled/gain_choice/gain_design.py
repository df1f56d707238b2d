"""What `design --gains` says: gains, the margins that they keep, and what they are worth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.hypotheses import Premises
from asmc_pin.sampled.gain_choice.gain_search import USEFUL, Margins
from asmc_pin.sampled.gain_choice.law_choice import Bought
from asmc_pin.sampled.gain_choice.pid_tuning import pid_of
from asmc_pin.sampled.noise.sensor_noise import NOISE_KEYS
from asmc_pin.sampled.sampled_loop import SampledLoop, settings_words
from asmc_pin.sampled.stability_report import StabilityReport, margin_words
from asmc_pin.words.shown import Shown
from asmc_pin.words.text import rounded_up

PID = "pid"
"""Name of the law of a design that is of a PID's own loop."""

_TIMING = ("acceleration", "filter_hz", "delay", "velocity", "velocity_filter_hz", "reading_delay", "pairing")
_KEPT = (*_TIMING, "kind", "spectral_radius", "rest_spectral_radius", "decay_rate", *NOISE_KEYS)
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
        noise_budget: RMS of torque that the sensor's noise was allowed, shape (nv,), N·m; None for any.
        law: Name of the law that they are for; empty for PPC, `PID` for the PID that PPC is with differences.
        bought: What they are worth against PPC's; None for PPC itself, and where it has none.
        unproven: Why no proof of the loop was tried; empty where one was, or was not asked for.
    """

    about: Premises
    unit: SampledLoop
    asked: Margins
    report: StabilityReport | None
    expected: ExpectedErrors | None
    why: tuple[str, ...]
    armature: Array | None
    noise_budget: Array | None = None
    unproven: str = ""
    law: str = ""
    bought: Bought | None = None

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
    def quiet(self) -> bool:
        """Whether the noise found keeps to its budget, if there is one."""
        if self.noise_budget is None:
            return True
        noise = None if self.report is None else self.report.noise
        return noise is not None and bool((noise.torque_rms <= self.noise_budget).all())

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
            "noise_budget": None if self.noise_budget is None else self.noise_budget.tolist(),
            "noise_met": None if self.noise_budget is None else self.quiet,
            "pid": None if self.report is None or self.law not in ("", PID) else pid_of(self.loop).to_json_dict(),
            "proof": {"verdict": "searched", "reason": self.unproven} if self.unproven else stable.get("proof"),
            "useful": self.useful,
            "law": None if self.report is None else stable.get("law"),
            "bought": None if self.bought is None else self.bought.to_json_dict(),
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
        if self.law and self.report is None:
            return [f"{title}: no gains of {self.law} that were tried have these margins: {asked}{self._quiet()}", mbar]
        if self.report is None or self.reached is None or self.expected is None:
            return [
                f"{title}: no β and k_s were found stable, with this M̄ or less of it",
                mbar,
                *self.why,
                *self._armature_line(),
            ]
        reached = margin_words(self.reached.gain, self.reached.delay, self.unit.period)
        weight = 1.0 if self.loop.law is None else float(self.loop.law.estimate_weight)
        share = weight * self.mbar_scale
        which = "which" if weight == 1.0 else f"of which c = {weight:.4g} times"
        said = [
            f"{title}: β = {self.loop.beta[0]:.6g} 1/s, k_s = {self.loop.ks[0]:.6g} 1/s, and this M̄, {which} is "
            f"{share:.6g} times the one above and so keeps its condition:"
            if share < 1.0
            else f"{title}: β = {self.loop.beta[0]:.6g} 1/s, k_s = {self.loop.ks[0]:.6g} 1/s, and this M̄:",
            mbar,
            *([f"law {self.law}: {settings_words(self.loop.law)}"] if self.law not in ("", PID) else []),
            *(["of the PID that keeps its own integral and is not told the torque applied"] if self.law == PID else []),
            f"with {self.loop.timing_words()}",
            f"margins, at rest under gravity and of the inertia alone, where searched: {reached}",
        ]
        if not self.met:
            said.append(f"no gains with the margins asked for were found: {asked}")
        if not self.useful:
            constant = rounded_up(1.0 / float(self.loop.ks.min()), 3)
            said.append(f"of no use: errors die with a time constant of 1/k_s = {constant} s")
        said += [*self._budget_line(), *self.why, *self._armature_line(), *self._proof_lines(), *self.expected.lines()]
        noise = [] if self.report.noise is None else self.report.noise.lines(self.loop)
        worth = [self.bought.line()] if self.bought is not None else []
        return [*said, *noise, *([pid_of(self.loop).line(self.loop)] if self.law in ("", PID) else []), *worth]

    def _quiet(self) -> str:
        return "" if self.noise_budget is None else f", with torque noise up to {_list(self.noise_budget)} N·m"

    def _budget_line(self) -> list[str]:
        if self.noise_budget is None:
            return []
        asked = f"torque RMS of {_list(self.noise_budget)} N·m"
        if self.quiet:
            return [f"noise budget kept, where searched: {asked}"]
        return [f"no gains that were tried with these margins keep to the noise budget: {asked}; reached: see below"]

    def _proof_lines(self) -> list[str]:
        """What is proven of the gains' loop; its margins are not."""
        if self.unproven:
            return [f"searched, not proven: {self.unproven}"]
        proof = None if self.report is None else self.report.proof
        if proof is None:
            return []
        lines = [*proof.lines(), "the margins are searched, not proven"]
        return [*lines, "so of the loop: stable where searched"] if proof.verdict == "undecided" else lines

    def _armature_line(self) -> list[str]:
        if (self.met and self.useful) or self.noise_budget is not None or self.law:
            return []
        if self.armature is None:
            return [f"no armature that was tried would allow these margins with k_s of {USEFUL:g} 1/s"]
        return [
            f"armature of {_list(self.armature)} kg·m² more would allow the margins asked for with k_s of at least "
            f"{USEFUL:g} 1/s, where searched"
        ]


def _list(values: Array) -> str:
    return "(" + ", ".join(f"{value:.3g}" if abs(value) > 1e-9 else "0" for value in values) + ")"
