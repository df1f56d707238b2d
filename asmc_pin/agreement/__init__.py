"""An arm against an independent engine: MuJoCo reads the same URDF, and has to say the same (docs/agreement.md).

Takes an arm; gives how far the two engines differ, and where. May import `arms`, `controllers`, `plant` and the engine.
"""

from __future__ import annotations

from asmc_pin.agreement.against_mujoco import agree
from asmc_pin.agreement.agreement_report import AgreementReport

__all__ = ["AgreementReport", "agree"]
