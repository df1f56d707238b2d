"""What the comparison of an arm with MuJoCo says."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.words.shown import Cells, Shown, figure

# Round-off leaves 1e-12; but an inertia that its exporter rounded to an impossible one MuJoCo gets up to 1e-9 smaller.
TOLERANCE = 1e-8
"""Of each of the three relative errors."""

Verdict = Literal["agrees", "disagrees", "not compared"]


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class AgreementReport(Shown):
    """Whether two engines that read the same URDF text give the same M, bias and motion.

    Attributes:
        arm: Name of the arm.
        sha256: Hash of its URDF.
        joints: Its moving joints, base first.
        engine: The other engine and its version.
        verdict: ``agrees``: every error is within `TOLERANCE`. ``disagrees``: one is not. ``not compared``: the other
            engine refuses the URDF, or M and bias agree and no motion could be integrated; `notes` has the reason.
        configurations: How many pairs (q, q̇) M and bias were compared at.
        runs: How many motions were compared.
        duration: Length of each, s.
        step: Its integration step, s.
        mass_error: Largest |ΔM_ij| / √(M_ii M_jj).
        mass_worst_q: Where, shape (nv,), rad (m where prismatic).
        bias_error: Largest |Δh_i| / (largest |h_i| of all configurations), h = C q̇ + g; a joint that neither gravity
            nor Coriolis torques move is judged by M_ii · 1 rad/s².
        bias_worst_q: Where, shape (nv,).
        bias_worst_v: With which velocity, shape (nv,), rad/s.
        motion_error: Largest distance of two runs in a joint / (its travel in that run).
        motion_worst_q: Start of that run, shape (nv,).
        mass_by_joint: Largest mass error in each joint's row, shape (nv,).
        bias_by_joint: Largest bias error of each joint, shape (nv,).
        motion_by_joint: Largest motion error of each joint, shape (nv,).
        notes: What the other engine was given otherwise than written, or why it refuses.
        seconds: Wall time.
    """

    arm: str
    sha256: str
    joints: tuple[str, ...]
    engine: str
    verdict: Verdict
    configurations: int
    runs: int
    duration: float
    step: float
    mass_error: float
    mass_worst_q: Array
    bias_error: float
    bias_worst_q: Array
    bias_worst_v: Array
    motion_error: float
    motion_worst_q: Array
    mass_by_joint: Array
    bias_by_joint: Array
    motion_by_joint: Array
    notes: tuple[str, ...]
    seconds: float

    def to_json_dict(self) -> dict[str, Any]:
        """The object that ``asmc-pin agree --json`` prints; undefined figures are None."""
        return {
            "arm": self.arm,
            "joints": list(self.joints),
            "engine": self.engine,
            "verdict": self.verdict,
            "tolerance": TOLERANCE,
            "configurations": self.configurations,
            "runs": self.runs,
            "duration": self.duration,
            "step": self.step,
            "mass_error": _number(self.mass_error),
            "mass_worst_q": _numbers(self.mass_worst_q),
            "bias_error": _number(self.bias_error),
            "bias_worst_q": _numbers(self.bias_worst_q),
            "bias_worst_v": _numbers(self.bias_worst_v),
            "motion_error": _number(self.motion_error),
            "motion_worst_q": _numbers(self.motion_worst_q),
            "mass_error_by_joint": _numbers(self.mass_by_joint),
            "bias_error_by_joint": _numbers(self.bias_by_joint),
            "motion_error_by_joint": _numbers(self.motion_by_joint),
            "notes": list(self.notes),
            "seconds": self.seconds,
        }

    def lines(self) -> list[str]:
        """The report in plain words, a line per finding."""
        if not math.isfinite(self.mass_error) and self.verdict == "not compared":
            return [f"{self.arm}: NOT COMPARED with {self.engine}", *self.notes]
        said = "Pinocchio NOT COMPARED" if self.verdict == "not compared" else f"Pinocchio {self.verdict.upper()}"
        text = [
            f"{self.arm}: {said} with {self.engine}; both read the same URDF text",
            f"M(q): {_against(self.mass_error)} of √(M_ii M_jj), {self.configurations} configurations, "
            f"worst at q = {_angles(self.mass_worst_q)}",
            f"C q̇ + g: {_against(self.bias_error)} of the joint's largest, worst at "
            f"q = {_angles(self.bias_worst_q)}, q̇ = {_angles(self.bias_worst_v)}",
        ]
        if not np.isnan(self.motion_worst_q).all():
            text.append(
                f"motion under the same torques: {_against(self.motion_error)} of the travel, "
                f"{self.runs} runs of {self.duration:g} s in steps of {1e3 * self.step:g} ms without friction, "
                f"worst from q = {_angles(self.motion_worst_q)}"
            )
        return text + [f"note: {line}" for line in self.notes]

    def table(self) -> Cells:
        """Header and rows of the errors joint by joint."""
        header = ["joint", "M(q)", "C q̇ + g", "motion"]
        columns = (self.mass_by_joint, self.bias_by_joint, self.motion_by_joint)
        rows = zip(self.joints, *columns, strict=True)
        return header, [[name, *(figure(value, ".1e") for value in values)] for name, *values in rows]


def _against(error: float) -> str:
    sign = "≤" if error <= TOLERANCE else ">"
    return f"largest difference {error:.1e} ({sign} {TOLERANCE:g})"


def _angles(values: Array) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in np.asarray(values)) + ")"


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _numbers(values: Array) -> list[float | None]:
    return [_number(float(value)) for value in values]
