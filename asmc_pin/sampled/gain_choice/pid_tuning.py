"""The PID that a loop is when it sees the world through differences of angles alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.sampled.gain_choice.stored_pid import StoredPid
from asmc_pin.sampled.sampled_loop import SampledLoop


@dataclass(frozen=True, eq=False)
class PidTuning:
    """τ_k = τ_{k−1} + K [e_k − e_{k−1} + (L/T_I) e_k + (T_D/L)(e_k − 2e_{k−1} + e_{k−2})], joint by joint.

    With v and q̈(t−L) by backward differences, of the reference too, and paired with the last torque, (7) is this to the
    last term: docs/stability.md.

    Attributes:
        k: Gain K, shape (nv,), N·m/rad.
        ti: Integral time T_I, shape (nv,), s.
        td: Derivative time T_D, shape (nv,), s.
    """

    k: Array
    ti: Array
    td: Array

    def to_json_dict(self) -> dict[str, Any]:
        """The figures of a loop with one β and one k_s: K per joint, one time each."""
        return {"k": self.k.tolist(), "ti": float(self.ti[0]), "td": float(self.td[0])}

    def line(self, loop: SampledLoop) -> str:
        """In a sentence, with whose margins it has."""
        margins = (
            "it is the loop of these margins"
            if is_pid(loop)
            else "its margins are those of that loop (--velocity difference --pairing last, no filter), not these"
        )
        k = ", ".join(f"{value:.6g}" for value in self.k)
        return (
            f"with v and q̈ by backward differences and the last torque this law equals the velocity-form PID of "
            f"K = ({k}) N·m/rad, T_I = {float(self.ti[0]):.6g} s, T_D = {float(self.td[0]):.6g} s; {margins}"
        )


def is_pid(loop: SampledLoop) -> bool:
    """Whether a loop is the PID's own: one that keeps its integral, or v by difference, the last torque, no filter."""
    if isinstance(loop.law, StoredPid):
        return True
    bare = loop.law is None and loop.filter_hz is None and loop.velocity_filter_hz is None
    return bare and loop.velocity == "difference" and not loop.averages_torque


def pid_of(loop: SampledLoop) -> PidTuning:
    """K = m̄K_d/L, T_I = K_d/K_p, T_D = 1/K_d with K_d = β + k_s, K_p = βk_s."""
    return PidTuning(k=np.asarray(loop.mbar * loop.kd / loop.period), ti=loop.kd / loop.kp, td=1.0 / loop.kd)
