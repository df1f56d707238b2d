"""Fields of frozen dataclasses that validate and copy what they are given, on construction.

Takes what a constructor is given; gives read-only values, or an error that names the field. May import numpy and what
is open to all.

A field that is one of these carries its meaning, unit and bound with it, so that the constructor, the error message,
the tables and the JSON Schema cannot tell different stories:

    @dataclass(frozen=True, kw_only=True, eq=False)
    class MyLaw(TdeLaw):
        gain: PerJoint = PerJoint("switching gain", "rad/s²", at_least=0.0)

Reading ``law.gain`` gives a read-only float64 array. A wrong type, sign, size or NaN is a `ParameterError` that names
the field.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from asmc_pin.lazy import load_on_first_use

if TYPE_CHECKING:
    from asmc_pin.parameters.array_parameters import OptionalPerJoint as OptionalPerJoint
    from asmc_pin.parameters.array_parameters import PerJoint as PerJoint
    from asmc_pin.parameters.array_parameters import PerTrial as PerTrial
    from asmc_pin.parameters.array_parameters import Values as Values
    from asmc_pin.parameters.array_parameters import match_joints as match_joints
    from asmc_pin.parameters.parameter_field import REQUIRED as REQUIRED
    from asmc_pin.parameters.parameter_field import AsGiven as AsGiven
    from asmc_pin.parameters.parameter_field import Choice as Choice
    from asmc_pin.parameters.parameter_field import Parameter as Parameter
    from asmc_pin.parameters.parameter_field import parameters_of as parameters_of
    from asmc_pin.parameters.scalar_parameters import OptionalScalar as OptionalScalar
    from asmc_pin.parameters.scalar_parameters import Scalar as Scalar
    from asmc_pin.parameters.scalar_parameters import ScalarOrWord as ScalarOrWord

__getattr__, __dir__, __all__ = load_on_first_use(__name__)
