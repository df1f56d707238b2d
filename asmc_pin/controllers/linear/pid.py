"""PID in velocity form: what an industrial robot runs, and what time-delay control is with differenced velocities."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.controllers.law_registry import law
from asmc_pin.controllers.one_trial.compiled_tde import BY_POSITION, FILTER_WEIGHT, OWN, PERIOD
from asmc_pin.controllers.one_trial.trial_step import Tick, TrialStep, trial_step
from asmc_pin.controllers.protocol import Sample
from asmc_pin.controllers.tde import TdeLaw
from asmc_pin.errors import ParameterError
from asmc_pin.parameters import OptionalPerJoint, match_joints


class PidState(NamedTuple):
    """What the law remembers; each (batch, nv).

    Attributes:
        ticks: Number of ticks taken.
        error: e at the last tick, rad.
        rate: ė there, measured or by difference, rad/s.
        acceleration: ë there, low-passed if a filter is set, rad/s².
    """

    ticks: int
    error: Array
    rate: Array
    acceleration: Array


KP, KI, KD = range(OWN, OWN + 3)
ERROR, RATE, CHANGE_OF_RATE = range(3)


@trial_step
def _step(tick: Tick, law: Array, memory: Array, work: Array, command: Array) -> None:
    first, period, weight = tick.ticks == 0, law[PERIOD, 0], law[FILTER_WEIGHT, 0]
    for i in range(command.size):
        error, rate = tick.q_ref[i] - tick.q[i], tick.v_ref[i] - tick.v[i]
        # Before t = 0 arm and reference are taken to have moved on unaccelerated.
        change, bend = period * rate, 0.0 * rate
        if not first:
            change = error - memory[ERROR, i]
            if law[BY_POSITION, i] != 0.0:
                rate = change / period
            bend = (rate - memory[RATE, i]) / period
            if weight != 1.0:
                bend = memory[CHANGE_OF_RATE, i] + weight * (bend - memory[CHANGE_OF_RATE, i])
        memory[ERROR, i], memory[RATE, i], memory[CHANGE_OF_RATE, i] = error, rate, bend
        command[i] = tick.torque[i] + (law[KP, i] * change + law[KI, i] * error + law[KD, i] * bend)


@law("pid")
@dataclass(frozen=True, kw_only=True, eq=False)
class Pid(TdeLaw):
    r"""τ = τ(t−L) + k_p Δe + k_i L e + k_d Δė: the increment of k_p e + k_i ∫e + k_d ė.

    As it adds to the torque that was really applied, a torque limit does not wind it up: it leaves the limit with the
    first sample that asks for less. The gains are those of ros2_control's PID, command = p·e + i·∫e + d·ė.

    They are given, or are those of time-delay control's twin (docs/laws.md): k_p = M̄(K_s + β)/L, k_i = M̄βK_s/L,
    k_d = M̄/L. With ``acceleration="position"`` ė is (e_k − e_{k−1})/L, otherwise what is measured.
    `filter_hz` is the corner of a low-pass on the derivative's increments; `pairing` is without effect.

    Attributes:
        kp: k_p, at least 0, N·m/rad; with it `ki` and `kd` are needed, and M̄, K_s, β only serve the log and analyses.
        ki: k_i, at least 0, N·m/(rad·s).
        kd: k_d, above 0, N·m·s/rad.

    Raises:
        ParameterError: as of `TdeLaw`, or some but not all of the three gains are given.
    """

    title: ClassVar[str] = "PID, velocity form with anti-windup"
    equation: ClassVar[str] = "τ = τ(t−L) + k_p Δe + k_i L e + k_d Δė"
    estimates: ClassVar[bool] = False
    reference: ClassVar[str] = "ros2_control's PID, as increments; Åström, Hägglund (2006), Advanced PID Control"
    oracle: ClassVar[str] = "the torque of PPC whose ė, q̈ and q̈_d are backward differences; e = h/k_p without integral"
    claim: ClassVar[str] = "None but what its own map shows; as TDC's twin it has TDC's tuning."
    fails: ClassVar[str] = (
        "By position its map is that of an unpaired second difference: unstable at a = 1.95 with K_s = β = 20 at "
        "1 kHz, where PPC is stable."
    )

    kp: OptionalPerJoint = OptionalPerJoint("k_p; M̄(K_s + β)/L if not given", "N·m/rad", at_least=0.0)
    ki: OptionalPerJoint = OptionalPerJoint("k_i; M̄βK_s/L if not given", "N·m/(rad·s)", at_least=0.0)
    kd: OptionalPerJoint = OptionalPerJoint("k_d; M̄/L if not given", "N·m·s/rad", above=0.0)

    # Not required where the gains are given, of which they then follow.
    mbar: OptionalPerJoint = OptionalPerJoint("diagonal of M̄", "kg·m²", above=0.0)
    ks: OptionalPerJoint = OptionalPerJoint("diagonal of K_s", "1/s", above=0.0)
    beta: OptionalPerJoint = OptionalPerJoint("β", "1/s", above=0.0)  # type: ignore[assignment]

    def __post_init__(self) -> None:
        given = [name for name in ("kp", "ki", "kd") if getattr(self, name) is not None]
        missing = [name for name in ("kp", "ki", "kd") if name not in given]
        if given and missing:
            raise ParameterError(missing[0], f"is missing; {given[0]} is given, and a PID needs kp, ki and kd")
        if given:
            self._stand_in()
        for name in ("mbar", "ks", "beta"):
            if getattr(self, name) is None:
                raise ParameterError(name, "is missing; give kp, ki and kd, or mbar, ks and beta")
        match_joints(self)

    def _stand_in(self) -> None:
        """M̄, K_s and β of the gains: M̄ = L k_d, and the poles of k_d x² − k_p x + k_i, or their real part."""
        kd = np.asarray(self.kd)
        half = 0.5 * self.kp / kd
        # A K_s has to be positive, also where there is no integral.
        apart = np.sqrt(np.maximum(half**2 - self.ki / kd, 0.0))
        slow = np.maximum(half - apart, 1e-9)
        for name, value in (("mbar", self.period * kd), ("ks", slow), ("beta", np.maximum(2.0 * half - slow, 1e-9))):
            if name == "mbar" or getattr(self, name) is None:
                self.__dict__[name] = np.asarray(value)

    @property
    def averages_torque(self) -> bool:
        """No: increments are added to the last torque."""
        return False

    @property
    def gains(self) -> tuple[Array, Array, Array]:
        """k_p, k_i and k_d, as given or of M̄, K_s and β; scalars or (nv,)."""
        if self.kp is not None:
            return self.kp, self.ki, self.kd
        kd = self.mbar / self.period
        return kd * (self.ks + self.beta), kd * self.ks * self.beta, kd

    def with_loop(self, mbar: Array, ks: Array, beta: Array, period: float) -> Self:
        """The same law in another loop; gains that are given are multiplied by what those of the twin would be."""
        if self.kp is None:
            return super().with_loop(mbar, ks, beta, period)
        pushed = mbar / self.mbar
        faster, stiffer = (ks + beta) / (self.ks + self.beta), ks * beta / (self.ks * self.beta)
        kp, ki, kd = self.kp * pushed * faster, self.ki * pushed * stiffer, self.kd * pushed
        return replace(self, kp=kp, ki=ki, kd=kd, ks=ks, beta=beta, period=period)

    def init(self, sample: Sample) -> PidState:
        """State before the first tick."""
        self.start(sample)
        return PidState(0, *(np.zeros_like(sample.q) for _ in range(3)))

    row_meanings: ClassVar[Mapping[str, str]] = {
        "kp": "k_p, N·m/rad",
        "ki": "L k_i, N·m/rad",
        "kd": "L k_d, N·m·s²/rad",
    }

    def own_rows(self) -> tuple[ArrayLike, ...]:
        """The gains k_p, L k_i and L k_d."""
        kp, ki, kd = self.gains
        return kp, self.period * ki, self.period * kd

    trial_step: ClassVar[TrialStep | None] = _step
