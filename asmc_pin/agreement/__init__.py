"""An arm against an independent engine: MuJoCo reads the same URDF, and has to say the same (docs/agreement.md)."""

from __future__ import annotations

from asmc_pin.agreement.compare import agree
from asmc_pin.agreement.report import AgreementReport

__all__ = ["AgreementReport", "agree"]
