"""The laws by the names that experiments use; each enters itself, ``@law("bsmc")`` above its class.

`asmc_pin.controllers` imports the files of the laws: only there is the registry complete.
"""

from __future__ import annotations

from asmc_pin.controllers.tde import TdeLaw
from asmc_pin.registering import registering

CONTROLLERS: dict[str, type[TdeLaw]] = {}
"""The laws by the names that experiments use."""

law = registering(CONTROLLERS)
