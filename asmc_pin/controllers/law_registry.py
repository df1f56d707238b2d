"""The laws by the names that experiments use; each enters itself, ``@law("bsmc")`` above its class.

`asmc_pin.controllers` imports the files of the laws: only there is the registry complete.
"""

from __future__ import annotations

from typing import Any

from asmc_pin.controllers.tde import TdeLaw
from asmc_pin.registering import registering

CONTROLLERS: dict[str, type[TdeLaw]] = {}
"""The laws by the names that experiments use."""

law = registering(CONTROLLERS)


def law_name(law: Any) -> str:
    """The name of a law of the package in experiments; of another what it calls itself, or its class."""
    own = str(getattr(law, "label", type(law).__name__))
    return next((name for name, cls in CONTROLLERS.items() if cls is type(law)), own)
