"""Periodic motions that go on for ever: multisine and Fourier series, with a smooth start from rest if wanted."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.controllers.protocol import Setpoint
from asmc_pin.errors import ParameterError
from asmc_pin.parameters import Scalar, Values
from asmc_pin.references.reference import as_times, held_outside, quintic_blend, reference_kind

_TERMS = "a list of terms per joint"
_RISE = "time over which the motion grows from rest"


@reference_kind("multisine")
@dataclass(frozen=True, kw_only=True, eq=False)
class Multisine:
    """q_i = offset_i + w(t) Σ_l amplitude_il sin(2π frequency_il t + phase_il).

    w grows from 0 to 1 over `rise` along 10x³ − 15x⁴ + 6x⁵, so that the motion starts at the offset and at rest; with
    rise = 0 it is 1 throughout.

    Attributes:
        offset: nv values, rad.
        amplitude: Shape (nv, terms), rad; or nv values for one term per joint.
        frequency: Hz, at least 0: shaped as amplitude, or one number for all, or where amplitude is (nv, terms) one per
            term, shared by the joints.
        phase: Like frequency, rad; default 0.
        rise: At least 0, s; default 0.

    Raises:
        ParameterError: wrong sizes or signs.
    """

    motion: ClassVar[str] = "offset + w(t) Σ amplitude sin(2π frequency t + phase)"

    offset: Values = Values("mean angle", "rad", axes=(1,), shape="a list of one per joint")
    amplitude: Values = Values("amplitude", "rad", axes=(1, 2), shape=_TERMS)
    frequency: Values = Values("frequency", "Hz", axes=(0, 1, 2), shape="a number or " + _TERMS, at_least=0.0)
    phase: Values = Values("phase", "rad", axes=(0, 1, 2), shape="a number or " + _TERMS, default=0.0)
    rise: Scalar = Scalar(_RISE, "s", at_least=0.0, default=0.0)

    def __post_init__(self) -> None:
        for _ in self._terms():  # so that wrong sizes are told here and not when the run starts
            pass

    @property
    def nv(self) -> int:
        """Number of joints."""
        return int(self.offset.size)

    @property
    def duration(self) -> float:
        """Infinity: it goes on for ever."""
        return math.inf

    def evaluate(self, t: Array) -> Setpoint:
        """The reference at the times t, (T,), s; fields of shape (T, nv). Before t = 0 it holds q(0)."""
        return _sum_of_sines(as_times(t), self.offset, self._terms(), self.rise)

    def _terms(self) -> Iterator[tuple[Array, Array, Array]]:
        amplitude = _per_term("amplitude", self.amplitude, self.nv, None)
        terms = amplitude.shape[1]
        frequency = _per_term("frequency", self.frequency, self.nv, terms, shared=self.amplitude.ndim == 2)
        phase = _per_term("phase", self.phase, self.nv, terms, shared=self.amplitude.ndim == 2)
        for column in range(terms):
            yield amplitude[:, column], 2.0 * math.pi * frequency[:, column], phase[:, column]


@reference_kind("fourier")
@dataclass(frozen=True, kw_only=True, eq=False)
class Fourier:
    """The finite Fourier series by which arms are usually excited (Swevers et al. 1997).

    q_i = offset_i + w(t) Σ_l [a_il/(ω l) sin(ω l t) − b_il/(ω l) cos(ω l t)],  l = 1 … terms,  ω = 2π base_hz:
    a and b are the coefficients of the velocity, Σ_l a_il cos(ω l t) + b_il sin(ω l t). w as in `Multisine`.

    Attributes:
        offset: nv values, rad.
        a: Shape (nv, terms), rad/s.
        b: Shape (nv, terms), rad/s.
        base_hz: Frequency of the first term, above 0, Hz; the motion repeats after 1/base_hz.
        rise: At least 0, s; default 0.

    Raises:
        ParameterError: wrong sizes or signs.
    """

    motion: ClassVar[str] = "offset + w(t) Σ_l [a_l/(ωl) sin(ωlt) − b_l/(ωl) cos(ωlt)], ω = 2π base_hz"

    offset: Values = Values("mean angle", "rad", axes=(1,), shape="a list of one per joint")
    a: Values = Values("cosine coefficients of the velocity", "rad/s", axes=(2,), shape=_TERMS)
    b: Values = Values("sine coefficients of the velocity", "rad/s", axes=(2,), shape=_TERMS)
    base_hz: Scalar = Scalar("frequency of the first term", "Hz", above=0.0)
    rise: Scalar = Scalar(_RISE, "s", at_least=0.0, default=0.0)

    def __post_init__(self) -> None:
        _per_term("a", self.a, self.nv, None)
        if self.b.shape != self.a.shape:
            raise ParameterError(
                "b", f"has the shape {self.b.shape} but a has {self.a.shape}; give both the same terms"
            )

    @property
    def nv(self) -> int:
        """Number of joints."""
        return int(self.offset.size)

    @property
    def duration(self) -> float:
        """Infinity: it goes on for ever."""
        return math.inf

    def evaluate(self, t: Array) -> Setpoint:
        """The reference at the times t, (T,), s; fields of shape (T, nv). Before t = 0 it holds q(0)."""
        return _sum_of_sines(as_times(t), self.offset, self._terms(), self.rise)

    def _terms(self) -> Iterator[tuple[Array, Array, Array]]:
        for column in range(self.a.shape[1]):
            omega = np.full(self.nv, 2.0 * math.pi * self.base_hz * (column + 1))
            # A sin x − B cos x = A sin x + B sin(x − π/2), each term by its own sine
            yield self.a[:, column] / omega, omega, np.zeros(self.nv)
            yield self.b[:, column] / omega, omega, np.full(self.nv, -0.5 * math.pi)


def _per_term(name: str, value: Array, nv: int, terms: int | None, shared: bool = False) -> Array:
    """The value as (nv, terms); a vector is one term per joint, or if shared one value per term."""
    table = value
    if value.ndim == 0:
        table = np.full((nv, terms or 1), value)
    elif value.ndim == 1:
        table = np.tile(value, (nv, 1)) if shared else value[:, None]
    if table.shape[0] != nv or (terms is not None and table.shape[1] != terms):
        expected = f"({nv}, {terms})" if terms is not None else f"({nv}, terms)"
        raise ParameterError(
            name,
            f"has the shape {value.shape}; expected {expected}: offset has {nv} joints"
            + (f", amplitude {terms} term(s)" if terms is not None else ""),
        )
    return table


def _sum_of_sines(t: Array, offset: Array, terms: Iterator[tuple[Array, Array, Array]], rise: float) -> Setpoint:
    """Offset plus the windowed sum of amplitude sin(ω t + phase); each term as (nv,) arrays of these three."""
    inside = t >= 0.0
    t = np.maximum(t, 0.0)
    q, v, a = (np.zeros((t.size, offset.size)) for _ in range(3))
    for amplitude, omega, phase in terms:
        angle = t[:, None] * omega + phase
        wave = amplitude * np.sin(angle)
        q += wave
        v += amplitude * omega * np.cos(angle)
        a -= omega**2 * wave
    if rise > 0.0:
        w, dw, ddw = (part[:, None] for part in quintic_blend(t / rise))
        dw, ddw = dw / rise, ddw / rise**2
        q, v, a = w * q, w * v + dw * q, w * a + 2.0 * dw * v + ddw * q
    return held_outside(inside, offset + q, v, a)
