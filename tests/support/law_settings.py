"""Values for the parameters of any registered law, and gains with which each holds one mass."""

from __future__ import annotations

from typing import Any

from asmc_pin.controllers import (
    CONTROLLERS,
    REQUIRED,
    OptionalScalar,
    PerJoint,
    Scalar,
    ScalarOrWord,
    TdeLaw,
    parameters_of,
)
from asmc_pin.parameters import OptionalPerJoint

HELD: dict[str, dict[str, Any]] = {
    "bsmc": {"gain": 5.0, "boundary": 0.05},
    "plestan2010": {"rate": 50.0, "epsilon": "4KL", "floor": 0.1},
    "baek2016": {"phi": 5.0, "alpha": 0.1, "epsilon": 0.05},
    "implicit": {"gain": 10.0, "share": 0.5},
    "dob": {"cutoff_hz": 50.0},
    "ivf": {"gain": 20.0},
    "ism": {"gain": 2.0},
    "sta": {"k1": 3.0, "k2": 10.0},
    "ntsm": {"stiffness": 8.0, "gain": 2.0, "boundary": 0.05},
    "barrier": {"width": 0.02, "limit": 40.0},
    "adrc": {"observer_hz": 60.0},
}
"""The laws' own gains for a mass of 1 kg with M̄ = 0.6, K_s = 12, β = 9, at 1 kHz; a law that is missing needs none."""


def own_parameters(name: str) -> dict[str, Any]:
    """The parameters of a registered law beyond the shared ones."""
    return {key: item for key, item in parameters_of(CONTROLLERS[name]).items() if key not in parameters_of(TdeLaw)}


def required_of(name: str, value: float) -> dict[str, float]:
    """That value for everything that a law requires of its own."""
    return {key: within(item, value) for key, item in own_parameters(name).items() if item.default is REQUIRED}


def numbers_of(name: str, value: float) -> dict[str, float]:
    """That value for every number of a law's own that is never absent."""
    optional = (OptionalPerJoint, OptionalScalar)
    return {
        key: within(item, value)
        for key, item in own_parameters(name).items()
        if isinstance(item, (PerJoint, Scalar, ScalarOrWord)) and not isinstance(item, optional)
    }


def within(item: Any, value: float) -> float:
    """The value, or as much above the parameter's lower bound where it is below that."""
    low = getattr(getattr(item, "bound", None), "at_least", None)
    return value if low is None or value >= low else low + value
