"""What a law is as a linear system, found by asking the law itself: its step at small readings, one after the other.

No law states its matrices, so that none can differ from its step. Joints are apart in every law that is linear here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from asmc_pin._typing import Array, BoolArray
from asmc_pin.controllers.one_trial.state_rows import as_rows, from_rows
from asmc_pin.controllers.protocol import Sample, Setpoint

NEAR, NEARER, FAR = 1e-9, 1e-60, 1e6
"""Sizes of the readings at which a law is asked: inside a boundary layer, inside one of gains or a period that a search
has made extreme, and beyond any."""

READINGS = 3  # angle, velocity, torque of the last period
_TOLERANCE = 1e-5


@dataclass(frozen=True, eq=False)
class LinearForm:
    """A law about a set point at 0, joint by joint: x_{k+1} = A x_k + B y_k, τ_k = C x_k + D y_k.

    The readings y are angle (rad), velocity (rad/s) and the torque reported for the last period (N·m); x holds the
    rows of the law's memory that reach its torque.

    Attributes:
        memory: A, shape (nv, n, n).
        readings: B, shape (nv, n, 3).
        out: C, shape (nv, n).
        direct: D, shape (nv, 3).
    """

    memory: Array
    readings: Array
    out: Array
    direct: Array


def linear_form(law: Any, nv: int, size: float = NEAR) -> LinearForm | None:
    """The law for readings of a size, or None where it is not linear there, as one that switches.

    Args:
        law: Any with the protocol's `init` and `step`.
        nv: Number of joints.
        size: Of the readings and of what is remembered, in SI units.
    """
    rest = np.zeros((1, nv))
    state = law.step(law.init(Sample(rest, rest, rest)), Sample(rest, rest, rest), Setpoint(rest, rest, rest))[1]
    rows = as_rows(state, (1, nv))[1].shape[1]
    probes = np.concatenate([np.zeros((1, rows + READINGS)), np.eye(rows + READINGS)])
    # Each alone, all doubled and turned round, and all together: what is linear adds up.
    mixed = np.random.default_rng(0).uniform(-1.0, 1.0, (4, rows + READINGS))
    asked = np.concatenate([probes, -2.0 * probes[1:], mixed])
    memory, command = _answers(law, asked * size, nv, rows)
    if not (np.isfinite(memory).all() and np.isfinite(command).all()) or command[0].any():
        return None  # a law that pushes at rest switches
    a = (memory[1 : len(probes)] - memory[0]) / size  # what was asked, rows, nv
    c = (command[1 : len(probes)] - command[0]) / size
    kept = _reaching(a[:rows], c[:rows])
    for found, part in ((a[:, kept], memory[:, kept]), (c, command)):
        expected = part[0] + size * np.tensordot(asked, found, axes=1)
        scale = np.abs(part).max() + np.finfo(float).tiny
        if not np.abs(expected - part).max() <= _TOLERANCE * scale:
            return None
    columns = np.append(kept, np.ones(READINGS, dtype=np.bool_))
    a, c = np.moveaxis(a[columns][:, kept], -1, 0).swapaxes(1, 2), c[columns].T
    n = int(kept.sum())
    return LinearForm(a[..., :n], a[..., n:], c[:, :n], c[:, n:])


def linear_throughout(law: Any, nv: int) -> bool:
    """Whether the law is linear for readings of any size, not just within a boundary layer."""
    near, far = linear_form(law, nv), linear_form(law, nv, FAR)
    if near is None or far is None or near.memory.shape != far.memory.shape:
        return False
    pairs = zip(vars(near).values(), vars(far).values(), strict=True)
    return all(np.allclose(one, other, rtol=1e-5, atol=1e-9 * np.abs(other).max(initial=0.0)) for one, other in pairs)


def _answers(law: Any, asked: Array, nv: int, rows: int) -> tuple[Array, Array]:
    """Memory, (asked, rows, nv), and torque, (asked, nv), after a step from what is asked, the same for every joint."""
    trials = len(asked)
    zero = np.zeros((trials, nv))
    still = Setpoint(zero, zero, zero)
    state = law.step(law.init(Sample(zero, zero, zero)), Sample(zero, zero, zero), still)[1]
    ticks, memory = as_rows(state, (trials, nv))
    memory += asked[:, :rows, None]
    q, v, torque = (np.repeat(asked[:, rows + i : rows + i + 1], nv, axis=1) for i in range(READINGS))
    with np.errstate(all="ignore"):
        command, after = law.step(from_rows(state, ticks, memory), Sample(q, v, torque), still)
    return as_rows(after, (trials, nv))[1], command


def _reaching(a: Array, c: Array) -> BoolArray:
    """Which rows of memory reach the torque, at once or through others, in any joint; shape (rows,)."""
    kept = (c != 0.0).any(axis=-1)
    for _ in range(len(kept)):
        kept = kept | (a[:, kept] != 0.0).any(axis=(1, 2))
    return np.asarray(kept)
