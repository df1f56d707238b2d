"""An arm against an independent engine: MuJoCo reads the same URDF, and has to say the same (docs/agreement.md)."""

from __future__ import annotations

from asmc_pin.agreement.against_mujoco import agree
from asmc_pin.agreement.agreement_report import AgreementReport

__all__ = ["AgreementReport", "agree"]
