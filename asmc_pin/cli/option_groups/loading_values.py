"""What the options of an arm say, as keywords of `load_arm` and as ranges."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeAlias

from asmc_pin.cli.option_groups.loading_options import LoadingOptions
from asmc_pin.cli.options import assignments, number, numbers, value_or_range
from asmc_pin.errors import ParameterError

Range: TypeAlias = tuple[float, float]


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


def single_keywords(loading: LoadingOptions) -> dict[str, Any]:
    """Keywords of `load_arm`, where a range means nothing.

    Raises:
        ParameterError: An option gives a range or a choice.
    """
    single, ranges = load_keywords(loading)
    if ranges:
        raise ParameterError(f"--{next(iter(ranges))}", "one value expected here, not a range")
    return single
