"""Studies: controllers compared on one motion, refined, tuned, and looked at.

Takes experiments; gives comparisons and their folders. May import all rooms but `reproduction` and `cli`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from asmc_pin.lazy import load_on_first_use

if TYPE_CHECKING:
    from asmc_pin.study.comparing import compare as compare
    from asmc_pin.study.comparison import Comparison as Comparison

__getattr__, __dir__, __all__ = load_on_first_use(__name__)
