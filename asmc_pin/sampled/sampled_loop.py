"""Gains and timing of the sampled loop (7), as its linear analysis takes them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any, get_args

import numpy as np
from numpy.typing import ArrayLike

from asmc_pin._typing import Array
from asmc_pin.controllers import TdeLaw, parameters_of
from asmc_pin.controllers.law_registry import law_name
from asmc_pin.controllers.linear_form import NEARER, LinearForm, linear_form
from asmc_pin.errors import ParameterError
from asmc_pin.numerics.float_range import LARGEST, SMALLEST
from asmc_pin.words.choices import Acceleration as Acceleration
from asmc_pin.words.choices import Pairing as Pairing
from asmc_pin.words.choices import Velocity as Velocity
from asmc_pin.words.joint_units import listed_with_units

_SAME_DELAY = 1e-9  # periods


@dataclass(frozen=True)
class SampledLoop:
    """Gains and timing of the sampled loop (7); validated, and broadcast to one value per joint.

    Attributes:
        mbar: Diagonal of M̄, shape (nv,), kg·m², positive. Its length fixes nv.
        ks: Diagonal of K_s, shape (nv,), 1/s, positive; a scalar is spread over the joints.
        beta: β, shape (nv,), 1/s, positive; a scalar is spread over the joints. The law has a scalar β; values per
            joint let the linear zone of a boundary layer be written as β + Kᵢ/Φᵢ.
        period: Control period L, s.
        acceleration: How q̈(t−L) is estimated: "velocity", (v_k − v_{k−1})/L, or "position",
            (q_k − 2q_{k−1} + q_{k−2})/L².
        filter_hz: Corner of the first-order low-pass on that estimate, Hz; None for no filter.
        delay: Transport delay of the torque in periods, fractions allowed: a command of t_k acts from t_k + delay·L on.
        velocity: How the drives make v: "measured" by itself, or the "difference" of two readings of the angle,
            (q_k − q_{k−1})/L.
        velocity_filter_hz: Corner of a first-order low-pass on that difference, Hz; None for no filter.
        reading_delay: Age of the readings of q and v when the law gets them, periods, fractions allowed.
        pairing: The torque that goes with the estimate: "last", "mean" of the last two, or the "matched" one: the mean
            where the estimate is a second difference of readings.
        law: A law that is linear, whose loop it is in the place of PPC's; None for PPC. Its M̄, K_s, β and period are
            those of the loop, and so `acceleration`, `filter_hz` and `pairing` say nothing then.

    Raises:
        ParameterError: a value has a wrong size, sign, or is not finite.
    """

    mbar: Array
    ks: Array
    beta: Array
    period: float
    acceleration: Acceleration = "velocity"
    filter_hz: float | None = None
    delay: float = 0.0
    velocity: Velocity = "measured"
    velocity_filter_hz: float | None = None
    reading_delay: float = 0.0
    pairing: Pairing = "matched"
    law: Any = None
    nv: int = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Check and freeze the values."""
        mbar = np.array(self.mbar, dtype=np.float64, ndmin=1)
        object.__setattr__(self, "nv", mbar.size)
        for name, unit in (("mbar", "kg·m²"), ("ks", "1/s"), ("beta", "1/s")):
            object.__setattr__(self, name, positive_per_joint(name, getattr(self, name), mbar.size, unit))
        if not (_is_number(self.period) and self.period > 0.0):
            raise ParameterError("period", f"got {self.period!r}; expected a positive time in s, such as 0.001")
        for name, words in (("acceleration", Acceleration), ("velocity", Velocity), ("pairing", Pairing)):
            if getattr(self, name) not in get_args(words):
                known = " or ".join(map(repr, get_args(words)))
                raise ParameterError(name, f"got {getattr(self, name)!r}; expected {known}")
        for name in ("filter_hz", "velocity_filter_hz"):
            corner = getattr(self, name)
            if corner is not None and not (_is_number(corner) and corner > 0.0):
                raise ParameterError(name, f"got {corner!r}; expected a positive frequency in Hz, or none")
        if self.velocity_filter_hz is not None and self.velocity == "measured":
            raise ParameterError("velocity_filter_hz", "is for a velocity by difference; this one is measured")
        for name in ("delay", "reading_delay"):
            if not (_is_number(getattr(self, name)) and getattr(self, name) >= 0.0):
                raise ParameterError(name, f"got {getattr(self, name)!r}; expected a number of periods, 0 or more")

        if self.law is not None and not hasattr(self.law, "step"):
            raise ParameterError(
                "law", f"{self.law!r} given, a law expected, such as CONTROLLERS['dob'](…); ppc is none"
            )
        if self.law is not None and not _linear_near(self.law, self.nv):
            hint = getattr(self.law, "linear_with", "")
            raise ParameterError(
                "law",
                f"'{law_name(self.law)}' is not linear near its set point"
                + (f"; with {hint} it is" if hint else ", it switches")
                + "; else of its loop only that of PPC can be analysed, which is what stands there without a law",
            )

    @cached_property
    def tuned_law(self) -> Any:
        """The law with the loop's M̄, K_s, β and period; None for PPC."""
        return None if self.law is None else self.law.with_loop(self.mbar, self.ks, self.beta, self.period)

    @cached_property
    def form(self) -> LinearForm:
        """The law with the loop's M̄, K_s, β and period, as a linear system.

        Raises:
            ParameterError: it does not take these values, or is not linear with them.
        """
        form = _form_at(self.law, *(x.tobytes() for x in (self.mbar, self.ks, self.beta)), self.period)
        if form is None:
            raise ParameterError("law", f"'{law_name(self.law)}' is not linear near its set point with these values")
        return form

    @cached_property
    def possible(self) -> bool:
        """Whether the law takes the loop's values, of which a period may bound some, and is linear with them."""
        try:
            return self.law is None or self.form is not None
        except ParameterError:
            return False

    def words(self, slides: Sequence[bool]) -> str:
        """All of it for a person to read.

        Args:
            slides: Which joints are prismatic.
        """

        def listed(values: Array) -> str:
            return f"diag({', '.join(f'{x:.10g}' for x in values)})"

        mbar = listed_with_units([f"{x:.10g}" for x in self.mbar], "inertia", slides)
        beta = f"{self.beta[0]:.10g}" if np.all(self.beta == self.beta[0]) else listed(self.beta)
        return (
            f"M̄ = diag{mbar}, K_s = {listed(self.ks)} 1/s, β = {beta} 1/s, L = {self.period:g} s, {self.timing_words()}"
        ) + ("" if self.law is None else f", law {law_name(self.law)} ({settings_words(self.law)})")

    def timing_words(self) -> str:
        """What it makes of its sensor, and its delay, for a person to read."""
        return (
            f"acceleration from {self.acceleration}"
            + ("" if self.filter_hz is None else f" through a filter of {self.filter_hz:g} Hz")
            + f" {self._sensor_words()}, delay {self.delay:g} periods ({1e3 * self.delay * self.period:.3g} ms)"
        )

    def _sensor_words(self) -> str:
        """How v is made and what torque goes with the estimate."""
        made = "measured" if self.velocity == "measured" else "a difference of angles"
        corner = "" if self.velocity_filter_hz is None else f" through a filter of {self.velocity_filter_hz:g} Hz"
        late = f", readings {self.reading_delay:g} periods old" if self.reading_delay else ""
        torques = "the mean of the last two torques" if self.averages_torque else "the last torque"
        return f"paired with {torques}, v {made}{corner}{late}"

    def scaled(self, *, mbar: float = 1.0, ks: float = 1.0, beta: float = 1.0, period: float = 1.0) -> SampledLoop:
        """The same loop with values multiplied by factors."""
        return replace(self, mbar=self.mbar * mbar, ks=self.ks * ks, beta=self.beta * beta, period=self.period * period)

    @property
    def kd(self) -> Array:
        """K_d = K_s + βI of (8), shape (nv,), 1/s."""
        return self.ks + self.beta

    @property
    def kp(self) -> Array:
        """K_p = βK_s of (8), shape (nv,), 1/s²."""
        return self.ks * self.beta

    @property
    def averages_torque(self) -> bool:
        """Whether the mean of the last two torques goes with the estimate."""
        return self.pairing == "mean" or (self.pairing == "matched" and self.differences_twice)

    @property
    def differences_twice(self) -> bool:
        """Whether the estimate of q̈(t−L) is a second difference of readings: a mean over two periods."""
        return self.acceleration == "position" or self.velocity == "difference"

    @property
    def torque_age(self) -> float:
        """Age of the torque that a new one starts from, middle of its time to middle of its time, in periods.

        1 + d, and ½ more for the mean of two; with a low-pass of weight c on the whole estimate 1/c in the place of 1.
        """
        weight = 1.0 if self.law is None else float(self.tuned_law.estimate_weight)
        return 1.0 / weight + self.delay + (0.5 if self.averages_torque else 0.0)

    @property
    def resting_beta(self) -> Array:
        """β, and what a law adds to it near the set point while nothing moves, shape (nv,), 1/s."""
        return self.beta if self.law is None else self.beta + np.asarray(self.tuned_law.resting_slope)

    @property
    def undamped_delay(self) -> float:
        """Delay that may come on top before a torque that alternates from tick to tick goes on for ever, periods.

        Such a torque moves no angle at the ticks, and so no v by difference: nothing is fed back of it. The last torque
        reported 1, 3, … periods late is again the same half of it, so z = −1 is a pole whatever M and the gains are.
        0 where that is so already, inf where it never is; the mean of two torques is 0, and a measured v sees it.
        """
        if self.velocity != "difference" or self.averages_torque or self.reading_delay % 1.0 != 0.0:
            return math.inf
        if self.law is not None:  # its own map says it, as far as rounding lets it
            return math.inf
        after = (1.0 - self.delay) % 2.0
        return 0.0 if min(after, 2.0 - after) < _SAME_DELAY else after

    @property
    def velocity_smoothing(self) -> float:
        """Share of the newest difference in the velocity, as `smoothing`."""
        return _share(self.velocity_filter_hz, self.period)

    @property
    def smoothing(self) -> float:
        """Share of the newest estimate in one step of the filter, 1 − exp(−2πfL); 1 without filter."""
        return _share(self.filter_hz, self.period)

    @property
    def modal(self) -> bool:
        """Whether one mode at a time suffices: K_s and β are multiples of the identity."""
        alike = np.all(self.ks == self.ks[0]) and np.all(self.beta == self.beta[0])
        return bool(alike and (self.law is None or (self.law.separates and _alike(self.law))))

    @property
    def mode(self) -> SampledLoop:
        """The loop of a single mode, with M̄ = 1; the mode's inertia is then 1/a."""
        one, ks, beta = np.ones(1), self.ks[:1], self.beta[:1]
        law = self.law
        if law is not None and law.nv is not None:
            law = law.with_loop(one, ks, beta, self.period)
        return replace(self, mbar=one, ks=ks, beta=beta, law=law)


def positive_per_joint(name: str, value: ArrayLike, nv: int, unit: str) -> Array:
    """A positive value per joint, read-only, from a scalar or nv values."""
    try:
        given = np.asarray(value, dtype=np.float64)
        spread = np.array(np.broadcast_to(given, (nv,)))
    except (TypeError, ValueError):
        raise ParameterError(name, f"got {value!r}; expected a number or {nv} of them, in {unit}") from None
    if not (np.isfinite(spread).all() and (spread > 0.0).all()):
        raise ParameterError(name, f"got {spread.tolist()}; every value must be finite and positive ({unit})")
    if spread.min(initial=1.0) < SMALLEST or spread.max(initial=1.0) > LARGEST:
        within = f"between {SMALLEST:g} and {LARGEST:g} ({unit})"
        raise ParameterError(name, f"got {spread.tolist()}; every value must be {within}")
    spread.flags.writeable = False
    return spread


def _alike(law: Any) -> bool:
    """Whether no parameter of a law's own is given joint by joint."""
    own = [name for name in parameters_of(type(law)) if name not in parameters_of(TdeLaw)]
    return all(np.ndim(getattr(law, name)) == 0 for name in own)


@lru_cache(maxsize=2048)
def _form_at(law: Any, mbar: bytes, ks: bytes, beta: bytes, period: float) -> LinearForm | None:
    """The form of a law with these values; loops that differ in their delay share it."""
    tuned = law.with_loop(*(np.frombuffer(values) for values in (mbar, ks, beta)), period)
    nv = len(mbar) // np.dtype(np.float64).itemsize
    return linear_form(tuned, nv) or linear_form(tuned, nv, NEARER)


@lru_cache(maxsize=64)
def _linear_near(law: Any, nv: int) -> bool:
    """Whether a law is linear near its set point; a search asks it of the same one over and over."""
    return linear_form(law, nv) is not None


def law_settings(law: Any) -> dict[str, Any]:
    """A law's own parameters, as JSON takes them."""
    own = [name for name in parameters_of(type(law)) if name not in parameters_of(TdeLaw)]
    values = {name: getattr(law, name) for name in own}
    return {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in values.items()}


def settings_words(law: Any) -> str:
    """The same in a row."""
    return ", ".join(f"{name} = {value}" for name, value in law_settings(law).items() if value is not None) or "none"


def _share(corner: float | None, period: float) -> float:
    return 1.0 if corner is None else -math.expm1(-2.0 * math.pi * corner * period)


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float, np.integer, np.floating)) and math.isfinite(value)
