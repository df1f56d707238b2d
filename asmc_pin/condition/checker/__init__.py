"""The independent check of a certificate.

Takes the file, through the reader of it (`condition.certificate.container`); gives what is proven, about the arm that
is inside. Nothing else of the prover, nor of the loader of arms, may be imported here: what is shared would not be
checked.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from asmc_pin.lazy import load_on_first_use

if TYPE_CHECKING:
    from asmc_pin.condition.checker.outcome import CheckedStatement as CheckedStatement
    from asmc_pin.condition.checker.outcome import CheckResult as CheckResult
    from asmc_pin.condition.checker.replay import check as check

__getattr__, __dir__, __all__ = load_on_first_use(__name__)
