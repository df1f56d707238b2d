"""How large a number of an arm may be: far beyond any arm, and small enough that no product of them overflows.

A slip of units (grams for kilograms, millimetres for metres, g·mm² for kg·m²) stays within these bounds on purpose:
such an arm can be computed with, and what looks like a slip is for a warning to say.
"""

from __future__ import annotations

MASS = 1e9
"""kg, of a link or a payload."""

INERTIA = 1e15
"""kg·m², of an entry of an inertia tensor, and of armature."""

LENGTH = 1e6
"""m, of an origin's or a centre's coordinate; and rad, of an angle at which a joint is placed or locked."""

LIMIT = 1e6
"""rad or m: a position limit beyond it is how some exporters write that there is none."""

FRICTION = 1e15
"""N·m or N·m·s/rad (N, N·s/m), of a joint."""

GRAVITY = 1e6
"""m/s²."""

RATIO = 1e6
"""Of a joint that mimics another, either way."""

MOVING_JOINTS = 32
"""Of an arm that is computed with, those that mimic others included; M(q) is dense, and a search takes thousands."""
