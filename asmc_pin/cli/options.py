"""Options that several commands share, and the parsing of their values.

ARM options name joints as the URDF does; every message says what was given and what was expected.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from asmc_pin.disk.file_access import check_writable
from asmc_pin.errors import ParameterError
from asmc_pin.words.choices import Condition
from asmc_pin.words.mistyped import no_number, seconds
from asmc_pin.words.text import as_number

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

ArmArgument: TypeAlias = Annotated[
    str, typer.Argument(metavar="ARM", help="A name (see 'asmc-pin arms'), or the path of a URDF or xacro file.")
]
MbarOption: TypeAlias = Annotated[
    str,
    typer.Option("--mbar", metavar="M1,M2,…", help="Diagonal of M̄ in kg·m², base to tip, or one value for all joints."),
]
ConditionOption: TypeAlias = Annotated[
    Condition, typer.Option("--condition", metavar="lemma1|weighted", help="lemma1: ‖I − M⁻¹M̄‖₂ < 1. weighted: M̄ ≺ 2M.")
]
BoxOption: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--box", metavar="JOINT=LO:HI", help="Range of a joint, rad or m; the rest keep the arm's own. Repeatable."
    ),
]
JsonOption: TypeAlias = Annotated[
    bool, typer.Option("--json", help="Print one JSON object and nothing else on standard output.")
]

CertifyOption: TypeAlias = Annotated[
    bool, typer.Option("--certify", help="Prove it over the whole box, as far as the budget goes.")
]


def _share(value: float) -> float:
    """``--gap``, seen before anything is searched."""
    if not 0.0 < value < 1.0:
        raise typer.BadParameter(f"{value:g} given, a number between 0 and 1 expected")
    return value


GapOption: TypeAlias = Annotated[
    float,
    typer.Option(
        "--gap", callback=_share, help="Relative distance of the scales proven and refuted to be content with."
    ),
]


def _span(text: str | float) -> float:
    """``--budget``; a default comes as the number it is."""
    try:
        span = seconds(text) if isinstance(text, str) else text
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None
    if not 0.0 < span < math.inf:
        raise typer.BadParameter(f"'{text}' given, a positive number of seconds expected, or 90s, 2m, 1h")
    return span


BudgetOption: TypeAlias = Annotated[
    float,
    typer.Option(
        "--budget",
        metavar="S",
        parser=_span,
        help="Time for the proof, 60 or 2m or 1h; for a design that and its own.",
    ),
]
CertificateOption: TypeAlias = Annotated[
    str | None,
    typer.Option("--certificate", metavar="FILE", help="Write the proof to a file that 'asmc-pin check' replays."),
]
ReportOption: TypeAlias = Annotated[
    str | None, typer.Option("--report", metavar="FILE", help="Write one page for a reviewer, .html or .md.")
]

Range: TypeAlias = tuple[float, float]


def number(text: str, option: str, instead: str = "") -> float:
    """One finite number, or a `ParameterError` that names the option.

    Args:
        text: As given.
        option: Its name.
        instead: Where several numbers may be given, if not here.
    """
    try:
        value = as_number(text)
    except ValueError:
        hint = f"; {instead}" if instead and "," in text else ""
        raise ParameterError(option, no_number(text) + hint) from None
    if not math.isfinite(value):
        raise ParameterError(option, f"'{text}' is not a finite number")
    return value


def numbers(text: str, option: str) -> list[float]:
    """Comma-separated numbers."""
    return [number(part.strip(), option) for part in text.split(",")]


def per_joint(text: str, option: str) -> float | list[float]:
    """One number for all joints, or comma-separated ones."""
    values = numbers(text, option)
    return values[0] if len(values) == 1 else values


def check_count(values: float | list[float] | None, option: str, arm: Arm) -> None:
    """Say how many values are missing, or too many, with the names of the joints that they are for.

    Raises:
        ParameterError: Neither one value for all nor one for each joint.
    """
    if isinstance(values, list) and len(values) != arm.nv:
        from asmc_pin.experiment.checks.experiment_checks import joints_of

        raise ParameterError(option, f"{len(values)} values given, but {joints_of(arm)}")


def value_or_range(text: str, option: str) -> float | Range:
    """``x`` or ``lo:hi`` with lo ≤ hi."""
    lo, colon, hi = text.strip().partition(":")
    if not colon:
        return number(lo, option)
    low, high = number(lo, option), number(hi, option)
    if low > high:
        raise ParameterError(option, f"the range '{text}' is empty: its lower end is above its upper end")
    return low, high


def assignments(items: Iterable[str] | None, option: str, expected: str, *, empty: bool = False) -> dict[str, str]:
    """``name=value`` items as a dictionary; a value may be empty where that means something."""
    result: dict[str, str] = {}
    for item in items or ():
        name, equals, value = item.partition("=")
        if not equals or not name or not (value or empty):
            raise ParameterError(option, f"'{item}' is not of the form {expected}")
        if name.strip() in result:
            raise ParameterError(option, f"'{name.strip()}' is given twice")
        result[name.strip()] = value
    return result


def parse_box(items: Iterable[str] | None) -> dict[str, Range] | None:
    """``--box joint=lo:hi`` items as {joint: (lo, hi)}."""
    box: dict[str, Range] = {}
    for joint, text in assignments(items, "--box", "JOINT=LO:HI").items():
        value = value_or_range(text, "--box")
        if not isinstance(value, tuple):
            raise ParameterError("--box", f"'{joint}={text}' is not of the form JOINT=LO:HI")
        box[joint] = value
    return box or None


def parse_bounds(items: Iterable[str] | None) -> dict[str, tuple[float | None, float | None]] | None:
    """``--bounds joint=lo:hi`` items as {joint: (lo, hi)}; an end left empty is no bound."""
    bounds: dict[str, tuple[float | None, float | None]] = {}
    for joint, text in assignments(items, "--bounds", "JOINT=LO:HI").items():
        ends = text.split(":")
        if len(ends) != 2:
            raise ParameterError("--bounds", f"'{joint}={text}' is not of the form JOINT=LO:HI")
        low, high = (number(end, "--bounds") if end.strip() else None for end in ends)
        bounds[joint] = (low, high)
    return bounds or None


def check_output(path: str | None) -> None:
    """Say that a file cannot be written before anything is computed for it; a folder that is missing is made."""
    if path is not None and Path(path).parent.exists():
        check_writable(path)


def report_path(text: str | None) -> Path | None:
    """``--report FILE``; the suffix chooses the form."""
    if text is None:
        return None
    path = Path(text)
    if path.suffix.lower() not in (".html", ".md"):
        raise ParameterError("--report", f"'{text}' ends in neither .html nor .md; the ending chooses the form")
    check_writable(path)
    return path
