"""A law as code for a robot: C99 translated from its Python, recorded vectors, and their check (docs/export.md).

Takes an experiment and a controller's label; gives C files that compute the same torque. May import the rooms that
make an experiment and run it; the translator in `translation` imports none of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from asmc_pin.lazy import load_on_first_use

if TYPE_CHECKING:
    from asmc_pin.codegen.exporting import Exported as Exported
    from asmc_pin.codegen.exporting import export as export

__getattr__, __dir__, __all__ = load_on_first_use(__name__)
