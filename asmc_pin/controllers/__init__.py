"""Control laws: frozen parameters plus explicit state, on batches of trials, blind to the arm that they drive.

Takes samples and set points; gives torque. May import numpy, numba, `parameters`, `numerics` and what is open to all. A
law of your own: docs/controllers.md; one in the package: docs/extending.md.
"""

from __future__ import annotations

from dataclasses import dataclass

from asmc_pin.controllers.law_registry import CONTROLLERS
from asmc_pin.controllers.promises.run_history import Findings, History, Promise
from asmc_pin.controllers.protocol import Controller, Sample, Setpoint
from asmc_pin.controllers.tde import AdaptiveState, TdeLaw, TdeState, signed, sliding_variable
from asmc_pin.parameters import (
    REQUIRED,
    Choice,
    OptionalScalar,
    Parameter,
    PerJoint,
    Scalar,
    ScalarOrWord,
    parameters_of,
)

# Every law's file, in the order of the tables. The import is what registers the law.
# isort: off
from asmc_pin.controllers.ppc import Ppc as Ppc
from asmc_pin.controllers.bsmc import Bsmc as Bsmc
from asmc_pin.controllers.plestan2010 import Plestan2010 as Plestan2010
from asmc_pin.controllers.baek2016 import Baek2016 as Baek2016
from asmc_pin.controllers.switching.implicit import Implicit as Implicit
from asmc_pin.controllers.linear.dob import Dob as Dob
from asmc_pin.controllers.linear.ivf import Ivf as Ivf
from asmc_pin.controllers.linear.pid import Pid as Pid
from asmc_pin.controllers.switching.ism import Ism as Ism
from asmc_pin.controllers.switching.sta import Sta as Sta
from asmc_pin.controllers.switching.ntsm import Ntsm as Ntsm
from asmc_pin.controllers.switching.barrier import Barrier as Barrier
from asmc_pin.controllers.linear.adrc import Adrc as Adrc
# isort: on

__all__ = [
    "CONTROLLERS",
    "REQUIRED",
    "AdaptiveState",
    "Choice",
    "Controller",
    "Findings",
    "History",
    "LawInfo",
    "OptionalScalar",
    "Parameter",
    "ParameterInfo",
    "PerJoint",
    "Promise",
    "Sample",
    "Scalar",
    "ScalarOrWord",
    "Setpoint",
    "TdeLaw",
    "TdeState",
    "controllers_table",
    "describe_laws",
    "describe_parameter",
    "parameters_of",
    "signed",
    "sliding_variable",
]


@dataclass(frozen=True, slots=True)
class ParameterInfo:
    """One parameter, as the tables show it.

    Attributes:
        name: Its name in Python and in TOML.
        meaning: What it is; the paper's letter where there is one.
        unit: Its unit, empty if it has none.
        per_joint: Whether one value per joint may be given.
        required: Whether it has to be given.
        default: What is used otherwise.
    """

    name: str
    meaning: str
    unit: str
    per_joint: bool
    required: bool
    default: object

    def __str__(self) -> str:
        unit = f" [{self.unit}]" if self.unit else ""
        return f"{self.name}{unit}" if self.required else f"{self.name}{unit} = {self.default}"


@dataclass(frozen=True, slots=True)
class LawInfo:
    """One law, as the tables show it.

    Attributes:
        name: Its name in `CONTROLLERS`.
        title: What it is, in words.
        equation: Its torque and adaptation in one line.
        reference: Where it comes from.
        parameters: Its own parameters, beyond the shared ones.
    """

    name: str
    title: str
    equation: str
    reference: str
    parameters: tuple[ParameterInfo, ...]


def controllers_table() -> list[dict[str, str]]:
    """One row per registered law, as README.md and ``asmc-pin controllers`` show them."""
    return [
        {
            "law": law.name,
            "what": law.title,
            "equation": law.equation,
            "own parameters": ", ".join(map(str, law.parameters)) or "none",
            "source": law.reference,
        }
        for law in describe_laws()
    ]


def describe_laws() -> tuple[LawInfo, ...]:
    """Every registered law with its own parameters, in the order of `CONTROLLERS`."""
    shared = parameters_of(TdeLaw)
    return tuple(
        LawInfo(
            name,
            law.title,
            law.equation,
            law.reference,
            tuple(describe_parameter(item) for key, item in parameters_of(law).items() if key not in shared),
        )
        for name, law in CONTROLLERS.items()
    )


def describe_parameter(item: Parameter[object, object]) -> ParameterInfo:
    """What a table shows of one field of a law."""
    required = item.default is REQUIRED
    return ParameterInfo(
        item.name, item.meaning, item.unit, isinstance(item, PerJoint), required, None if required else item.default
    )
