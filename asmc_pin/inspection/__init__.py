"""What was read of a URDF, and what is doubtful about it: `inspect`, and the doubts that loading commands print.

Takes a name or a path with the options of `load_arm`; gives an `Inspection`, for refused arms too. May import `arms`
and `viewer`, which draws; steps no dynamics.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from asmc_pin.lazy import load_on_first_use

if TYPE_CHECKING:
    from asmc_pin.inspection.inspecting import inspect as inspect
    from asmc_pin.inspection.inspection_report import Inspection as Inspection
    from asmc_pin.inspection.subject_of_doubt import Doubt as Doubt

__getattr__, __dir__, __all__ = load_on_first_use(__name__)
