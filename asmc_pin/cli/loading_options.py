"""The options that say which arm it is: one list of them for every command that loads an arm.

A new option of `load_arm` is a field of `LoadingOptions` here, a line in `load_keywords`, and a field of the
experiment's `ArmTable`; every command then has it.
"""

from __future__ import annotations

import dataclasses
import functools
import inspect
import shlex
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias, get_type_hints

import typer

from asmc_pin.cli.console import announce_compiling, note
from asmc_pin.cli.options import assignments, number, numbers, value_or_range
from asmc_pin.errors import ParameterError

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

Range: TypeAlias = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class LoadingOptions:
    """What the command line says about the arm besides its name; None is what was not given."""

    payload: Annotated[
        str | None,
        typer.Option(
            "--payload",
            metavar="KG|LO:HI[@LINK]",
            help="Point mass at a link's frame, or a range of it; default the last moving link.",
        ),
    ] = None
    payload_com: Annotated[
        str | None,
        typer.Option(
            "--payload-com", metavar="X,Y,Z", help="The payload's centre of mass in its link, m; values or ranges."
        ),
    ] = None
    payload_inertia: Annotated[
        str | None,
        typer.Option(
            "--payload-inertia",
            metavar="XX,XY,XZ,YY,YZ,ZZ",
            help="The payload's inertia about its centre, kg·m²; of a range of masses that of the heaviest.",
        ),
    ] = None
    armature: Annotated[
        str | None,
        typer.Option(
            "--armature",
            metavar="A1,LO:HI,…|published",
            help="Reflected rotor inertia per joint, kg·m², values or ranges, or one for all; or what is published.",
        ),
    ] = None
    lock: Annotated[
        list[str] | None,
        typer.Option(
            "--lock",
            metavar="JOINT=ANGLE",
            help="Lock a joint at an angle, rad or m, or all that a pattern such as 'left_*' matches; 'grippers' locks "
            "those of grippers; 'free' frees one. Repeatable.",
        ),
    ] = None
    chain: Annotated[
        str | None,
        typer.Option(
            "--chain", metavar="BASE:TIP", help="Keep the joints between two links; the others are locked near zero."
        ),
    ] = None
    repair: Annotated[
        bool, typer.Option("--repair", help="Take inertia tensors that no rigid body has to the nearest, and say so.")
    ] = False
    gravity: Annotated[
        str | None,
        typer.Option(
            "--gravity", metavar="X,Y,Z", help="Gravity in the base frame, m/s²; 0,0,9.81 hangs it from a ceiling."
        ),
    ] = None
    xacro: Annotated[
        list[str] | None,
        typer.Option("--xacro", metavar="NAME=VALUE", help="An argument of a xacro file. Repeatable."),
    ] = None
    package: Annotated[
        list[str] | None,
        typer.Option("--package", metavar="NAME=DIR", help="Where a ROS package lies that is named. Repeatable."),
    ] = None
    estimate_inertia: Annotated[
        list[str] | None,
        typer.Option(
            "--estimate-inertia",
            metavar="KG|LINK=KG",
            help="Estimate missing inertias from shapes: a mass for all together, or one for each link. Repeatable.",
        ),
    ] = None
    plant: Annotated[
        str | None,
        typer.Option(
            "--plant",
            metavar="FILE",
            help="Payload and armature with their intervals, as 'asmc-pin identify --out FILE' measured them.",
        ),
    ] = None


_SINGLE: dict[str, Any] = {
    "payload": typer.Option(
        "--payload", metavar="KG[@LINK]", help="Point mass at a link's frame; default the last moving link."
    ),
    "payload_com": typer.Option("--payload-com", metavar="X,Y,Z", help="The payload's centre of mass in its link, m."),
    "payload_inertia": typer.Option(
        "--payload-inertia", metavar="XX,XY,XZ,YY,YZ,ZZ", help="The payload's inertia about its centre, kg·m²."
    ),
    "armature": typer.Option(
        "--armature",
        metavar="A1,A2,…|published",
        help="Reflected rotor inertia per joint, kg·m², or one value for all; or what is published.",
    ),
}
"""The options that take a range elsewhere, of a command where one means nothing."""

NOTHING = LoadingOptions()
"""No option at all."""


def takes_loading_options(
    *, without: tuple[str, ...] = (), ranges: bool = True
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Decorate a command: its parameter ``loading: LoadingOptions`` becomes the options of that class.

    Args:
        without: Fields that mean nothing to this command.
        ranges: Whether ranges mean something to it.
    """

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        hints = get_type_hints(LoadingOptions, include_extras=True)
        if not ranges:
            hints |= {name: Annotated[str | None, option] for name, option in _SINGLE.items()}
        options = [
            inspect.Parameter(
                each.name, inspect.Parameter.KEYWORD_ONLY, default=each.default, annotation=hints[each.name]
            )
            for each in dataclasses.fields(LoadingOptions)
            if each.name not in without
        ]
        parameters: list[inspect.Parameter] = []
        for parameter in inspect.signature(command, eval_str=True).parameters.values():
            shared = parameter.name == "loading"
            parameters += options if shared else [parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY)]

        @functools.wraps(command)
        def run(**given: Any) -> None:
            loading = LoadingOptions(**{each.name: given.pop(each.name) for each in options})
            command(loading=loading, **given)

        # What typer reads in place of the command's own.
        run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        run.__annotations__ = {each.name: each.annotation for each in parameters}
        del run.__wrapped__
        return run

    return decorate


def parse_payload(text: str | None, com: str | None = None, inertia: str | None = None) -> dict[str, Any] | None:
    """``--payload``, ``--payload-com`` and ``--payload-inertia`` as a mapping, in which ranges are tuples."""
    if text is None:
        for option, given in (("--payload-com", com), ("--payload-inertia", inertia)):
            if given is not None:
                raise ParameterError(option, f"'{given}' given without a payload; add --payload KG[@LINK]")
        return None
    mass, at, link = text.partition("@")
    if at and not link.strip():
        raise ParameterError("--payload", f"'{text}' names no link after '@'; write it like 2@tool0")
    payload: dict[str, Any] = {"mass": value_or_range(mass, "--payload")}
    if at:
        payload["link"] = link.strip()
    for key, option, given, size in (("com", "--payload-com", com, 3), ("inertia", "--payload-inertia", inertia, 6)):
        if given is None:
            continue
        parts = given.split(",")
        if len(parts) != size:
            raise ParameterError(option, f"'{given}' has {len(parts)} values, {size} expected")
        payload[key] = [value_or_range(part, option) if size == 3 else number(part, option) for part in parts]
    return payload


def parse_armature(text: str | None) -> list[float | Range] | float | Range | str | None:
    """``--armature`` as per-joint values or ranges, or one for all joints, kg·m²; or the word ``published``."""
    if text is None:
        return None
    if text.strip() == "published":
        return "published"
    if text.strip().isalpha():
        raise ParameterError("--armature", f"'{text}' given, numbers in kg·m², ranges lo:hi, or 'published' expected")
    parts = [value_or_range(part, "--armature") for part in text.split(",")]
    return parts[0] if len(parts) == 1 else parts


def load_keywords(loading: LoadingOptions) -> tuple[dict[str, Any], dict[str, Any]]:
    """Read the options.

    Returns:
        Keywords of `load_arm`, all that has one value; and the ranges and choices, keywords of `verify` and its
        fellows.
    """
    single: dict[str, Any] = {}
    ranges: dict[str, Any] = {}
    load: Any = parse_payload(loading.payload, loading.payload_com, loading.payload_inertia)
    rotors: Any = parse_armature(loading.armature)
    if loading.plant is not None:
        from asmc_pin.experiment.measured_values import measured_ranges, read_measured

        measured = measured_ranges(read_measured(Path(loading.plant)).get("arm", {}))
        load = measured.get("payload") if load is None else load
        load = {"mass": load} if isinstance(load, float | int | tuple) else load
        rotors = measured.get("armature") if rotors is None else rotors
    if load is not None:
        spread = any(isinstance(x, tuple) for x in (load["mass"], *load.get("com", ())))
        (ranges if spread else single)["payload"] = load
    if rotors is not None:
        spread = any(isinstance(x, tuple) for x in (rotors if isinstance(rotors, list) else [rotors]))
        (ranges if spread else single)["armature"] = rotors
    asked = [f"{item}=0" if item.strip() == "grippers" else item for item in loading.lock or ()]
    given = assignments(asked, "--lock", "JOINT=ANGLE or JOINT=free")
    locks = {joint: numbers(value, "--lock") for joint, value in given.items() if value != "free"}
    held: dict[str, Any] = {joint: angles[0] for joint, angles in locks.items()}
    held |= {joint: None for joint, value in given.items() if value == "free"}
    choices = {joint: angles for joint, angles in locks.items() if len(angles) > 1}
    if choices:
        ranges["lock"] = choices
    if held:
        single["lock"] = held
    if loading.chain is not None:
        ends = loading.chain.split(":")
        if len(ends) != 2 or not all(ends):
            raise ParameterError("--chain", f"'{loading.chain}' is not of the form BASE:TIP, two names of links")
        single["chain"] = (ends[0], ends[1])
    if loading.repair:
        single["repair"] = True
    if loading.gravity is not None:
        single["gravity"] = numbers(loading.gravity, "--gravity")
    if loading.xacro:
        # An empty value is one: many a xacro file takes "no gripper" that way.
        single["xacro"] = assignments(loading.xacro, "--xacro", "NAME=VALUE", empty=True)
    if loading.package:
        single["package"] = assignments(loading.package, "--package", "NAME=DIR")
    if loading.estimate_inertia:
        single["estimate_inertia"] = parse_estimate(loading.estimate_inertia)
    return single, ranges


def parse_estimate(items: list[str]) -> float | dict[str, float]:
    """``--estimate-inertia`` as one mass, or link to mass, kg."""
    option = "--estimate-inertia"
    if len(items) == 1 and "=" not in items[0]:
        return number(items[0], option)
    masses = assignments(items, option, "LINK=KG; give one mass for all, or one for each link")
    return {link: number(mass, option) for link, mass in masses.items()}


def open_domain(source: str, loading: LoadingOptions) -> tuple[Arm, dict[str, Any]]:
    """Load an arm as the command line describes it, its warnings on standard error.

    Args:
        source: ARM.
        loading: The options.

    Returns:
        The arm with all that has one value, and the ranges and choices as keywords of `verify` and its fellows.
    """
    from asmc_pin.arms.registry import find

    single, ranges = load_keywords(loading)
    find(source)  # a name that is none is told before anything heavy is loaded
    announce_compiling()
    from asmc_pin.arms import load_arm

    arm = load_arm(source, **single)
    if loading.plant is not None:
        from asmc_pin.experiment.measured_values import check_measured_arm, read_measured

        check_measured_arm(read_measured(Path(loading.plant)), arm.source_name, Path(loading.plant).name)
    for proviso in arm.provisos:
        if not proviso.headline:
            note(f"{proviso.kind}: {proviso.text}")
    warnings = list(arm.warnings)
    if "payload" in ranges:
        from asmc_pin.condition.domain.payload_ranges import carrying

        # What is said of every payload of the range.
        laden = [other for other, _ in carrying(arm, ranges["payload"]) if other.payload and other.payload.mass > 0.0]
        common = set.intersection(*(set(other.warnings) for other in laden)) if laden else set()
        warnings += sorted(common - set(warnings))
    for warning in warnings:
        note(f"warning: {warning}")
    for proviso in arm.provisos:
        if proviso.headline:
            note(f"warning: {proviso.kind}: {proviso.text}")
    tell_doubts(arm, source)
    return arm, ranges


def tell_doubts(arm: Arm, source: str) -> None:
    """Say on standard error what puts an arm's M(q) in doubt, a line each, and where there is more."""
    from asmc_pin.inspection.inspecting import serious_doubts

    doubts = serious_doubts(arm)
    for doubt in doubts:
        note(f"warning: doubtful: {doubt.text}")
    if doubts:
        note(f"warning: see 'asmc-pin inspect {shlex.quote(source)}' for what was read")


def single_keywords(loading: LoadingOptions) -> dict[str, Any]:
    """Keywords of `load_arm`, where a range means nothing.

    Raises:
        ParameterError: An option gives a range or a choice.
    """
    single, ranges = load_keywords(loading)
    if ranges:
        raise ParameterError(f"--{next(iter(ranges))}", "one value expected here, not a range")
    return single


def open_single(source: str, loading: LoadingOptions) -> Arm:
    """The same where a range means nothing.

    Raises:
        ParameterError: An option gives a range or a choice.
    """
    single_keywords(loading)
    arm, _ = open_domain(source, loading)
    return arm
