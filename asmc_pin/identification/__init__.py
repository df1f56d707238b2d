"""Logs of a real robot in, plant parameters with intervals out: `identify` (docs/identification.md).

Takes an arm and a `JointLog`; gives how right the URDF is, estimates, and the plant's tables for other commands. May
import `arms`, `logs`, `condition`, and what they may; steps no dynamics.
"""

from __future__ import annotations
