"""The independent check of a certificate.

In comes the file, through the reader of it (`condition.certificate.container`); out goes what is proven, about the arm
that is inside. Nothing else of the prover, nor of the loader of arms, may be imported here: what is shared would not be
checked.
"""

from asmc_pin.condition.check.outcome import CheckedStatement, CheckResult
from asmc_pin.condition.check.replay import check

__all__ = ["CheckResult", "CheckedStatement", "check"]
