"""Studies: comparing controllers on one motion."""

from __future__ import annotations

from asmc_pin.study.compare import compare
from asmc_pin.study.comparison import Comparison

__all__ = ["Comparison", "compare"]
