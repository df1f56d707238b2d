"""NTSM: nonsingular terminal sliding mode control, which reaches e = 0 in a finite time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.controllers.bsmc import saturated
from asmc_pin.controllers.law_registry import law
from asmc_pin.controllers.one_trial.compiled_tde import (
    BETA,
    MBAR,
    OWN,
    PAST_ACCELERATION,
    PAST_TORQUE,
    tde_terms,
    with_sign,
)
from asmc_pin.controllers.one_trial.trial_step import Tick, TrialStep, trial_step
from asmc_pin.controllers.promises.run_history import Promise
from asmc_pin.controllers.promises.terminal_time import TerminalTime
from asmc_pin.controllers.tde import TdeLaw
from asmc_pin.numerics.short_loops import short_loops
from asmc_pin.parameters import PerJoint, Scalar

EXPONENT, STIFFNESS, GAIN, BOUNDARY = range(OWN, OWN + 4)


@short_loops
def terminal_surface(error: float, rate: float, exponent: float, stiffness: float) -> float:
    """The surface e + |ė|^p sgn(ė)/B of one joint, rad."""
    return float(error + with_sign(abs(rate) ** exponent, rate) / stiffness)


@trial_step
def _step(tick: Tick, law: Array, memory: Array, work: Array, command: Array) -> None:
    tde_terms(tick, law, memory, work)
    for i in range(command.size):
        p, stiffness, gain, boundary = law[EXPONENT, i], law[STIFFNESS, i], law[GAIN, i], law[BOUNDARY, i]
        rate = tick.v_ref[i] - tick.v[i]
        sigma = terminal_surface(tick.q_ref[i] - tick.q[i], rate, p, stiffness)
        slide = stiffness / p * with_sign(abs(rate) ** (2.0 - p), rate)
        w = law[BETA, i] * stiffness * sigma + gain * saturated(sigma, boundary)
        load = work[PAST_ACCELERATION, i] - work[PAST_TORQUE, i] / law[MBAR, i]
        command[i] = law[MBAR, i] * (tick.a_ref[i] + slide + w - load)


@law("ntsm")
@dataclass(frozen=True, kw_only=True, eq=False)
class Ntsm(TdeLaw):
    r"""τ = τ(t−L) − M̄ q̈(t−L) + M̄ (q̈_d + (B/p) ⌈ė⌋^{2−p} + β B σ + K sat(σ/Φ)),  σ = e + (1/B) ⌈ė⌋^p.

    ⌈x⌋^p = |x|^p sgn x. On σ = 0 the error obeys ė = −(B e)^{1/p}: |e|^{1−1/p} falls linearly, to 0 at
    t = |e₀|^{1−1/p} / (B^{1/p} (1 − 1/p)). With p = 1 the law is PPC with K_s = B. The logged s is that of (4), with
    `ks`; σ is not a velocity.

    Attributes:
        exponent: p, at least 1, below 2; between odd numbers' ratios such as 9/7 and 5/3 it is commonly chosen.
        stiffness: B, scalar or nv values, above 0, with e in rad and ė in rad/s; 1/s for p = 1.
        gain: K, scalar or nv values, at least 0, rad/s².
        boundary: Φ, the half-width of the boundary layer in σ, scalar or nv values, above 0, rad.
    """

    title: ClassVar[str] = "nonsingular terminal sliding mode control"
    equation: ClassVar[str] = (
        "τ = τ(t−L) − M̄ q̈(t−L) + M̄ (q̈_d + (B/p) ⌈ė⌋^{2−p} + β B σ + K sat(σ/Φ));  σ = e + ⌈ė⌋^p / B"
    )
    reference: ClassVar[str] = "Feng, Yu, Man (2002), Automatica; with TDE: Jin, Lee, Chang, Choi (2009), IEEE TIE"
    oracle: ClassVar[str] = (
        "p = 1 is PPC with K_s = B; |e|^{1−1/p} falls linearly on σ = 0, e is 0 in time but for order L"
    )
    claim: ClassVar[str] = "e reaches 0 in finite time."
    fails: ClassVar[str] = (
        "Near ė = 0 the term |ė|^{2−p} is endlessly steep: sampled, the law chatters there, within the boundary "
        "layer too."
    )
    linear_with: ClassVar[str] = "exponent = 1 (and |σ| < Φ), where it is PPC with K_s = B,"
    band_remedy: ClassVar[str] = "lower its B (stiffness) or K (gain), or widen Φ (boundary)"
    typical: ClassVar[Mapping[str, float | str]] = {"stiffness": 8.0, "gain": 2.0, "boundary": 0.05}

    exponent: Scalar = Scalar("p", at_least=1.0, below=2.0, default=5.0 / 3.0)
    stiffness: PerJoint = PerJoint("B", "(rad/s)^p/rad", above=0.0)
    gain: PerJoint = PerJoint("K", "rad/s²", at_least=0.0)
    boundary: PerJoint = PerJoint("Φ", "rad", above=0.0)

    row_meanings: ClassVar[Mapping[str, str]] = {
        "exponent": "p, no unit",
        "stiffness": "B, (rad/s)^p/rad",
        "gain": "K, rad/s²",
        "boundary": "Φ, rad",
    }

    def own_rows(self) -> tuple[ArrayLike, ...]:
        """The exponent p and B, K, Φ."""
        return self.exponent, self.stiffness, self.gain, self.boundary

    trial_step: ClassVar[TrialStep | None] = _step

    def promises(self) -> Mapping[str, Promise | str]:
        """That e is gone in finite time, but for what the boundary layer leaves."""
        if self.exponent == 1.0:
            return {
                "finite_time": "with p = 1 the law is PPC, of which e dies away like an exponential, never at a time"
            }
        parts = self.exponent, self.stiffness, self.gain, self.boundary, self.beta
        return {"finite_time": TerminalTime(*parts)}
