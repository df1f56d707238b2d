"""The tables of a measured plant: ``[arm]`` and ``[plant]`` with intervals, for every other command."""

from __future__ import annotations

from typing import Any

from asmc_pin.identification.estimates import Estimate
from asmc_pin.identification.identification_report import Identification
from asmc_pin.identification.measured_load import estimated, measured_armature, measured_load
from asmc_pin.words.text import printable

_FRICTION = ("coulomb", "viscous", "breakaway", "stribeck_velocity")


def plant_tables(found: Identification) -> dict[str, Any]:
    """What the estimates mean for a plant.

    What no plant has, torque constants and offsets of the log and a delay of its torque, is not in here: it is a fact
    about the log, and `asmc-pin identify --json` has it.

    Args:
        found: With estimates.

    Returns:
        Tables by name, as an experiment has them; values as ``{ low, value, high }``.
    """
    names = found.arm.joint_names
    table: dict[str, Any] = {"source": _source(found)}
    load = _payload(found)
    if load is not None:
        table["payload"] = load
    if estimated(found.parameters, "armature"):
        given = [f"armature.{name}" in found.parameters for name in names]
        whole = measured_armature(found)
        table["armature"] = [each.as_dict() if own else each.value for each, own in zip(whole, given, strict=True)]
    friction: dict[str, Any] = {}
    for kind in _FRICTION:
        if not estimated(found.parameters, kind):
            continue
        friction[kind] = [_value(found, f"{kind}.{name}", _default(found, kind, name)) for name in names]
    if "breakaway" in friction and "coulomb" in friction:
        friction["breakaway"] = [_above(*pair) for pair in zip(friction["breakaway"], friction["coulomb"], strict=True)]
    return {"arm": table, "plant": {"friction": friction}} if friction else {"arm": table}


def plant_text(found: Identification) -> str:
    """The same as TOML, with a heading that says where it comes from."""
    tables = plant_tables(found)
    lines = [
        f"# What the log '{printable(found.log.name)}' says of {printable(found.arm.name)}, in 95 % intervals.",
        "# Give it to compare, sweep, verify, design, bounds or stability as --plant FILE.",
        "",
        "[arm]",
    ]
    lines += [f"{key} = {_toml(value)}" for key, value in tables["arm"].items()]
    if "plant" in tables:
        lines += ["", "[plant.friction]"]
        lines += [f"{key} = {_toml(value)}" for key, value in tables["plant"]["friction"].items()]
    mass = found.parameters.get("payload.mass")
    if mass is not None and "payload" not in tables["arm"]:
        lines += [
            "",
            f"# The log asks for a payload of {mass.value:.4g} kg, and no arm carries less than nothing: left out.",
        ]
    return "\n".join(lines) + "\n"


def _toml(value: Any, indent: str = "    ") -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        parts = [_toml(item) for item in value]
        if any(isinstance(item, dict) for item in value) and len(value) > 3:
            return "[\n" + "".join(f"{indent}{part},\n" for part in parts) + "]"
        return "[" + ", ".join(parts) + "]"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    return repr(float(f"{value:.6g}"))


def _source(found: Identification) -> str:
    entry = found.arm.made_of.entry
    return entry.name if entry is not None else str(found.arm.source)


def _payload(found: Identification) -> dict[str, Any] | None:
    measured = measured_load(found)
    if measured is None:
        return None
    load: dict[str, Any] = {"mass": measured.mass.as_dict()}
    if measured.com is not None:
        load["com"] = [each.as_dict() for each in measured.com]
    if measured.inertia is not None and any(measured.inertia):
        load["inertia"] = list(measured.inertia)
    load["link"] = measured.link
    return load


def _value(found: Identification, name: str, otherwise: float) -> Any:
    each = found.parameters.get(name)
    return otherwise if each is None else _clipped(each)


def _clipped(each: Estimate) -> dict[str, float]:
    return {"low": max(each.low, 0.0), "value": max(each.value, 0.0), "high": max(each.high, 0.0)}


def _above(breakaway: Any, coulomb: Any) -> Any:
    """A level of breaking loose that is not below Coulomb friction, wherever each lies in its interval."""
    least = coulomb["high"] if isinstance(coulomb, dict) else coulomb
    if isinstance(breakaway, dict):
        return {end: max(value, least) for end, value in breakaway.items()}
    return max(breakaway, least)


def _default(found: Identification, kind: str, name: str) -> Any:
    if kind == "breakaway":  # no weakening seen: as much as Coulomb friction may be
        each = found.parameters.get(f"coulomb.{name}")
        return 0.0 if each is None else _clipped(each)["high"]
    return {"stribeck_velocity": 0.01}.get(kind, 0.0)
