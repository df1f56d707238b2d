"""The words that an option is chosen from, for the library and for the command line."""

from __future__ import annotations

from typing import Literal, TypeAlias

Condition: TypeAlias = Literal["lemma1", "weighted"]
"""``lemma1``: ‖I − M⁻¹M̄‖₂ < 1. ``weighted``: M̄ ≺ 2M, that is max|1 − λ(M⁻¹M̄)| < 1."""

Objective: TypeAlias = Literal["contraction", "bandwidth"]
Form: TypeAlias = Literal["diagonal", "scalar"]
Acceleration: TypeAlias = Literal["velocity", "position"]
RealType: TypeAlias = Literal["double", "float"]
"""Of the numbers in exported code."""
Target: TypeAlias = Literal["c", "ros2_control"]
"""What an export is for."""
Velocity: TypeAlias = Literal["measured", "difference"]
"""How a drive's velocity is made: measured by itself, or the difference of two readings of the angle."""
Pairing: TypeAlias = Literal["matched", "last", "mean"]
"""Which torque goes with an estimate of q̈(t−L): what fits it, that of the last period, the mean of the last two."""
