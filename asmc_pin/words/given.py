"""What was given in the place of an object that a call makes: said with that call, where it takes what was given."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from asmc_pin.errors import ParameterError


def check_made(parameter: str, given: Any, *, has: str, kind: str, by: str) -> None:
    """Say so where something else stands in the place of an object.

    Args:
        parameter: Its parameter's name.
        given: What was given.
        has: A name that only such an object has.
        kind: What was expected.
        by: The function that makes one of a name or a path.

    Raises:
        ParameterError: It has no such name.
    """
    if not hasattr(given, has):
        made = f": {by}({str(given)!r})" if isinstance(given, str | Path) else f"; {by} makes one"
        raise ParameterError(parameter, f"{given!r} given, {kind} expected{made}")


def check_arm(given: Any) -> None:
    """That it is an arm, and not the name of one."""
    check_made("arm", given, has="mass_matrix", kind="an Arm", by="load_arm")


def check_experiment(given: Any) -> None:
    """That it is an experiment, and not the name of one or its file."""
    check_made("experiment", given, has="controllers", kind="an Experiment", by="load_experiment")
