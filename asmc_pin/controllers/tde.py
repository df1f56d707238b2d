r"""Pole-placement control with time-delay estimation, the part that every law here shares.

In the letters of Baek, Jin and Han (2016), equations by their numbers there:

    e = q_d − q,   (4)  s = ė + K_s e
    (6)  Γ̂(t) = q̈(t−L) − M̄⁻¹ τ(t−L)
    (7)  τ = τ(t−L) − M̄ q̈(t−L) + M̄ (q̈_d + K_s ė + β s)

τ(t−L) and q̈(t−L) are a pair: the torque has to be that of the time over which the acceleration is a mean.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.controllers.one_trial.compiled_law import CompiledLaw, check_trials
from asmc_pin.controllers.one_trial.compiled_tde import shared_control, surface, with_sign
from asmc_pin.controllers.promises.run_history import Promise
from asmc_pin.controllers.protocol import Sample, Setpoint
from asmc_pin.errors import ParameterError
from asmc_pin.numerics.short_loops import as_written
from asmc_pin.parameters import Choice, OptionalScalar, PerJoint, Scalar, match_joints

PAIRINGS = ("matched", "last", "mean")
"""What `TdeLaw.pairing` may be."""

_surface, _with_sign = as_written(surface), as_written(with_sign)


def sliding_variable(ks: Array | float, sample: Sample, setpoint: Setpoint) -> Array:
    """The sliding variable (4), s = ė + K_s e with e = q_d − q.

    Args:
        ks: Diagonal of K_s, a scalar or shape (nv,), 1/s.
        sample: What the drives report; fields of shape (..., nv).
        setpoint: The reference there; fields that broadcast against the sample's.

    Returns:
        s, shape (..., nv), rad/s; positive where the joint lags behind a reference that moves up.
    """
    return np.asarray(_surface(np.asarray(ks), sample.q, sample.v, setpoint.q, setpoint.v))


def signed(gain: Array, s: Array) -> Array:
    """The switching term K̂ sgn(s) for K̂ ≥ 0, with sgn(0) = +1 (10) and no smoothing."""
    return np.asarray(_with_sign(gain, s))


class TdeState(NamedTuple):
    """What time-delay estimation remembers between two ticks.

    Attributes:
        ticks: Number of ticks taken.
        position: q at the last tick, (batch, nv), rad.
        velocity: v at the last tick, or with ``acceleration="position"`` (q_k − q_{k−1})/L there, (batch, nv), rad/s.
        acceleration: The estimate of q̈(t−L) used at the last tick, filtered if a filter is set, (batch, nv), rad/s².
        torque: What the drives reported at the last tick, (batch, nv), N·m.
    """

    ticks: int
    position: Array
    velocity: Array
    acceleration: Array
    torque: Array


class AdaptiveState(NamedTuple):
    """State of a law with an adaptive gain.

    Attributes:
        tde: What the estimation remembers.
        gain: k̂ of this tick, (batch, nv), rad/s²; all columns equal where one gain is shared by the joints.
    """

    tde: TdeState
    gain: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class TdeLaw(CompiledLaw):
    r"""What all laws with time-delay estimation share: the parameters of PPC, eq. (7), and that equation itself.

    A law derives from this class and adds its own term. The attributes below say what the loop is without that term;
    the analysis of the sampled loop reads them. `switching_term`, `boundary_slope` and `theorem1` say what the term is.

    Attributes:
        mbar: Diagonal of M̄, scalar or nv values, above 0, kg·m².
        ks: Diagonal of K_s, scalar or nv values, above 0, 1/s.
        beta: β, above 0, 1/s.
        period: Control period L, above 0, s.
        acceleration: How q̈(t−L) is estimated: ``"velocity"``, (v_k − v_{k−1})/L, or ``"position"``,
            (q_k − 2 q_{k−1} + q_{k−2})/L².
        filter_hz: Corner frequency of a first-order low-pass on that estimate, above 0, Hz; None for no filter.
        pairing: Which torque goes with that estimate as τ(t−L): ``"last"``, that of the last period; ``"mean"``, the
            mean of the last two, for an estimate that is a second difference of position and so the mean acceleration
            of two periods; ``"matched"``, the one that fits ``acceleration``. The law cannot see how a drive makes its
            velocity: where that is by difference, give ``"mean"``; an experiment does, for its sensor.

    Raises:
        ParameterError: a parameter has a wrong type, size or sign, or is not finite.
    """

    title: ClassVar[str] = ""
    equation: ClassVar[str] = ""
    reference: ClassVar[str] = ""
    oracle: ClassVar[str] = ""
    """What it does exactly, or in which order."""
    claim: ClassVar[str] = ""
    """What its source claims."""
    fails: ClassVar[str] = ""
    """When that does not hold."""
    typical: ClassVar[Mapping[str, float | str]] = {}
    """Values of its own parameters to begin with: they hold two_link, ur5 and panda at 1 kHz, K_s = β = 8."""
    estimates: ClassVar[bool] = True
    """Whether its load estimate is Γ̂ of (6), low-passed with `estimate_weight` or not; the monitors' N needs it."""
    band_remedy: ClassVar[str] = "lower its own gains"
    """What helps where the loop is unstable inside the band in which the law is linear."""
    linear_with: ClassVar[str] = ""
    """With what values a law that is not linear near its set point would be; empty where with none."""
    separates: ClassVar[bool] = False
    """Whether M̄⁻¹τ depends on M̄ through M̄⁻¹ of the reported torque alone, so that modes of M⁻¹M̄ separate."""
    theorem1: ClassVar[bool] = False
    """Whether Lemma 2, (16) and Theorem 1 are proved for it: it adapts by (11), with φ, α, ε and a threshold."""

    row_meanings: ClassVar[Mapping[str, str]] = {
        "mbar": "diagonal of M̄, kg·m²",
        "ks": "diagonal of K_s, 1/s",
        "beta": "β, 1/s",
        "filter_weight": "weight of the newest value in the low-pass on q̈(t−L), no unit; 1: no filter",
        "by_position": "1: q̈(t−L) by second differences of the angle; 0: by differences of the velocity; no unit",
        "averages_torque": "1: the mean of the last two torques goes with it; 0: the last torque; no unit",
    }

    mbar: PerJoint = PerJoint("diagonal of M̄", "kg·m²", above=0.0)
    ks: PerJoint = PerJoint("diagonal of K_s", "1/s", above=0.0)
    beta: Scalar = Scalar("β", "1/s", above=0.0)
    period: Scalar = Scalar("control period L", "s", above=0.0)
    acceleration: Choice = Choice("estimate of q̈(t−L)", ("velocity", "position"), default="velocity")
    filter_hz: OptionalScalar = OptionalScalar("low-pass corner of that estimate", "Hz", above=0.0)
    pairing: Choice = Choice(
        "torque that goes with it: of the last period, mean of the last two, or what fits", PAIRINGS, default="matched"
    )

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """A class derived from a law may do something else in a tick: what it does not say itself is not known."""
        super().__init_subclass__(**kwargs)
        for name in ("switching_term", "theorem1", "promises"):
            if name not in vars(cls):
                setattr(cls, name, vars(TdeLaw)[name])

    def __post_init__(self) -> None:
        match_joints(self)

    @property
    def nv(self) -> int | None:
        """Number of joints that the parameters are for; None if every one of them is a scalar and fits any arm."""
        return int(self.mbar.size) if self.mbar.ndim else None

    @property
    def filter_weight(self) -> float:
        """Weight c of the newest value in the low-pass y_k = y_{k−1} + c (x_k − y_{k−1}); 1 without a filter.

        c = 1 − exp(−2π f L), the exact discretisation of a first-order lag whose input is held over L.
        """
        return 1.0 if self.filter_hz is None else -math.expm1(-2.0 * math.pi * self.filter_hz * self.period)

    @property
    def averages_torque(self) -> bool:
        """Whether the mean of the last two torques goes with the estimate of q̈(t−L), and not the last one."""
        return self.pairing == "mean" or (self.pairing == "matched" and self.acceleration == "position")

    @property
    def estimate_weight(self) -> Any:
        """Weight c of the newest Γ̂ in a low-pass on the whole estimate, above 0 and at most 1; 1 without one.

        The condition on M̄ is then one on cM̄.
        """
        return 1.0

    def switching_term(self, s: Array, gain: Array) -> Array | None:
        """w, what the law adds to PPC inside the bracket that M̄ multiplies: τ = PPC + M̄ w; of one class alone.

        Args:
            s: The sliding variable at every tick from t = 0 on, (batch, T, nv), rad/s.
            gain: What the law's state called ``gain`` at these ticks, likewise; NaN where it has none.

        Returns:
            w at these ticks, (batch, T, nv), rad/s²; None if the law does not say.
        """
        return None

    def promises(self) -> Mapping[str, Promise | str]:
        """What its source claims of a run, by the monitors' keys, or why it does not here; of one class alone."""
        return {}

    @property
    def boundary_slope(self) -> Array | None:
        """dw/ds inside a boundary layer, where it acts as so much more β, a scalar or (nv,), 1/s; None without one."""
        return None

    @property
    def resting_slope(self) -> Any:
        """dw/ds near the set point while nothing moves, a scalar or (nv,), 1/s: so much more β to a drifting load."""
        return 0.0 if self.boundary_slope is None else self.boundary_slope

    def for_joints(self, nv: int) -> Self:
        """The same law with every per-joint parameter of shape (nv,).

        Raises:
            ParameterError: the law is for another number of joints.
        """
        self._check_joints(nv)
        return self if self.nv is not None else replace(self, mbar=np.full(nv, self.mbar))

    def with_loop(self, mbar: Array, ks: Array, beta: Array, period: float) -> Self:
        """The same law in another loop: M̄ and K_s of shape (nv,), β (nv,) with equal values, period in s."""
        return replace(self, mbar=mbar, ks=ks, beta=float(beta[0]), period=period)

    def init(self, sample: Sample) -> Any:
        """State before the first tick, from the sample of t = 0; a law with a state of its own overrides it."""
        return self.start(sample)

    def start(self, sample: Sample) -> TdeState:
        """State of the estimation before the first tick.

        Raises:
            ParameterError: the sample's fields are not all (batch, nv), or nv is not that of the parameters.
        """
        shape = sample.q.shape
        if len(shape) != 2 or sample.v.shape != shape or sample.torque.shape != shape:
            raise ParameterError(
                "sample",
                f"q, v and torque have the shapes {shape}, {sample.v.shape} and {sample.torque.shape}; "
                "expected (batch, nv) for all three",
            )
        self._check_joints(shape[1])
        return TdeState(0, sample.q.copy(), sample.v.copy(), np.zeros(shape), sample.torque.copy())

    def rows(self) -> tuple[ArrayLike, ...]:
        """The parameters as the compiled step has them: those of (7), then the law's own, see `own_rows`."""
        by_position = self.acceleration == "position"
        shared = (self.mbar, self.ks, self.beta, self.period, self.filter_weight, by_position, self.averages_torque)
        return *shared, *self.own_rows()

    def own_rows(self) -> tuple[ArrayLike, ...]:
        """What the compiled step needs beyond the rows of (7), a scalar or (nv,) each, from row `OWN` on."""
        return ()

    def pole_placement(self, state: TdeState, sample: Sample, setpoint: Setpoint) -> tuple[Array, Array, TdeState]:
        """The shared control (7), for a law that has its step in numpy.

        Args:
            state: What the estimation remembers of the last tick.
            sample: What the drives report now; its torque is τ(t−L), or half of it where two are averaged.
            setpoint: The reference now.

        Returns:
            The torque (7), (batch, nv), N·m; the sliding variable s (4), (batch, nv), rad/s; the next state.
        """
        q, v, applied = sample.q, sample.v, sample.torque
        batch, nv = shape = q.shape
        law, out = self.law_rows(nv), np.empty((6, batch, nv))
        if len(law) != 1:
            check_trials(law, batch)
        ticks, *past = state
        control = shared_control()
        try:
            done = control(ticks, law, q, v, applied, setpoint.q, setpoint.v, setpoint.a, *past, out)
        except TypeError:  # whole numbers, say
            done = False
        if not done:
            given = (q, v, applied, setpoint.q, setpoint.v, setpoint.a, *past)
            control(ticks, law, *(np.broadcast_to(np.asarray(x, dtype=np.float64), shape) for x in given), out)
        torque, s, position, velocity, acceleration, reported = out
        return torque, s, TdeState(ticks + 1, position, velocity, acceleration, reported)

    def _check_joints(self, nv: int) -> None:
        if self.nv is not None and self.nv != nv:
            raise ParameterError(
                "mbar", f"has {self.nv} values but the arm has {nv} joints; give {nv} values or a single number"
            )

    def __reduce__(self) -> tuple[Any, ...]:
        # Through the constructor, so that a copy in another process is as read-only as this one.
        return partial(type(self), **{f.name: getattr(self, f.name) for f in fields(self)}), ()
