"""The options that name a law and its own parameters, for the commands that speak of a sampled loop."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from asmc_pin.cli.options import assignments, per_joint
from asmc_pin.errors import ParameterError
from asmc_pin.words.nearest_name import nearest

if TYPE_CHECKING:
    from asmc_pin.controllers import TdeLaw
    from asmc_pin.parameters import Parameter

LawOption: TypeAlias = Annotated[
    str | None,
    typer.Option("--law", metavar="NAME", help="A law that is linear near its set point, in the place of ppc."),
]
SetOption: TypeAlias = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="A parameter of that law; repeat for more.")
]


SHARED = ("mbar", "ks", "beta", "period", "acceleration", "filter_hz", "pairing")
"""Parameters that every law has, and that options of their own give."""


def law_of(name: str | None, settings: list[str] | None, **shared: Any) -> TdeLaw | None:
    """The law that --law and --set name, with the loop's own values; None for PPC."""
    values = settings_of(name, settings, shared)
    if name is None:
        return None
    from asmc_pin.controllers import CONTROLLERS
    from asmc_pin.parameters import REQUIRED, parameters_of

    known = parameters_of(CONTROLLERS[name])
    absent = [key for key, item in known.items() if item.default is REQUIRED and key not in {*shared, *values}]
    if absent:
        raise ParameterError("--set", f"'{name}' needs {absent[0]}; give --set {absent[0]}=VALUE")
    return CONTROLLERS[name](**shared, **values)


def settings_of(name: str | None, settings: list[str] | None, shared: Collection[str] = SHARED) -> dict[str, Any]:
    """The parameters of a law's own that --set gives; those of every law are given otherwise."""
    if name is None:
        if settings:
            raise ParameterError("--set", f"{settings[0]!r} given without --law; say which law it is for")
        return {}
    from asmc_pin.baselines import BASELINES
    from asmc_pin.controllers import CONTROLLERS
    from asmc_pin.parameters import parameters_of

    if name in BASELINES:
        raise ParameterError(
            "--law",
            f"'{name}' computes with a model of the arm: its loop follows from how good that model is, and has no map "
            "in M̄, K_s and β; run it with 'asmc-pin compare'",
        )
    if name not in CONTROLLERS:
        raise ParameterError("--law", f"there is no law '{name}': {nearest(name, CONTROLLERS)}")
    given = assignments(settings, "--set", "KEY=VALUE, such as cutoff_hz=50")
    known = parameters_of(CONTROLLERS[name])
    for key in given:
        if key not in known or key in shared:
            own = [key for key in known if key not in shared]
            raise ParameterError(
                "--set", f"'{name}' has no parameter '{key}' of its own; it has {', '.join(own) or 'none'}"
            )
    return {key: _value(known[key], text, f"--set {key}") for key, text in given.items()}


def _value(item: Parameter[Any, Any], text: str, option: str) -> Any:
    from asmc_pin.parameters import Choice

    if text == "inf":
        return math.inf
    return text if isinstance(item, Choice) else per_joint(text, option)
