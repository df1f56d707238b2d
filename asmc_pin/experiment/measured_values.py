"""Values that were measured: ``{ low, value, high }`` in the place of a number in ``[arm]`` and ``[plant]``.

A comparison takes the value. A sweep draws from a normal distribution about it, whose 95 % the interval is, and within
the interval, unless ``[sweep]`` says otherwise of that key. The condition's commands take low to high as a range
(``--plant``).
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from asmc_pin.errors import ExperimentError
from asmc_pin.experiment.toml_text import read_toml

KEYS = frozenset({"low", "value", "high"})
PLACES = ("arm", "plant")

_WIDTH = 1.96  # standard deviations on each side of a normal's 95 %


def is_interval(value: object) -> bool:
    """Whether a value is an interval."""
    return isinstance(value, Mapping) and set(value) == KEYS


def with_values(data: dict[str, Any]) -> dict[str, Any]:
    """The tables with the value in the place of each interval, and a line of ``[sweep]`` for what it leaves open.

    Args:
        data: Tables of an experiment.

    Raises:
        ExperimentError: An interval's ends are no numbers, or not in order.
    """
    axes: dict[str, Any] = {}
    plain = {key: _taken(item, key, axes) if key in PLACES else item for key, item in data.items()}
    own = plain.get("sweep", {})
    if not axes or not isinstance(own, Mapping):
        return plain
    # What somebody varies by hand varies so alone, and so does all within it.
    free = {path: axis for path, axis in axes.items() if not any(_covers(other, path) for other in own)}
    return {**plain, "sweep": {**own, **free}} if free else plain


def read_measured(path: Path) -> dict[str, Any]:
    """The tables ``[arm]`` and ``[plant]`` of a file that `identify` wrote, intervals and all.

    Raises:
        ExperimentError: It cannot be read, or has neither of them.
    """
    _, data = read_toml(path)
    found = {key: data[key] for key in PLACES if isinstance(data.get(key), Mapping)}
    if not found:
        raise ExperimentError("", f"{path.name} has neither [arm] nor [plant]; a file of 'asmc-pin identify --out' has")
    return found


def with_measured(data: Mapping[str, Any], measured: Mapping[str, Any]) -> dict[str, Any]:
    """An experiment's tables with measured ones laid over them; what was not measured stays.

    Raises:
        ExperimentError: The measured arm is another one.
    """
    arm = data.get("arm")
    own = arm if isinstance(arm, Mapping) else {"source": arm}
    asked = measured.get("arm", {}).get("source", own.get("source"))
    if own.get("source") not in (None, asked):
        raise ExperimentError(
            "arm.source", f"the experiment's is {own.get('source')!r}, the measured plant's {asked!r}"
        )
    return {**data, **{key: _laid({"arm": own}.get(key, data.get(key, {})), measured[key]) for key in measured}}


def check_measured_arm(measured: Mapping[str, Any], source: str, name: str) -> None:
    """Refuse a plant that was measured on another arm.

    Args:
        measured: Of `read_measured`.
        source: Of the arm that is asked about, `Arm.source_name`.
        name: Of the file.

    Raises:
        ExperimentError: It was.
    """
    asked = measured.get("arm", {}).get("source", source)
    same = asked == source or (Path(str(asked)).is_file() and Path(str(asked)).resolve() == Path(source).resolve())
    if not same:
        raise ExperimentError("arm.source", f"{name} was measured on {asked!r}, and the arm is {source!r}")


def measured_ranges(arm: Mapping[str, Any]) -> dict[str, Any]:
    """Payload and armature of a measured ``[arm]`` as options of the condition's commands: intervals as ranges."""
    found: dict[str, Any] = {}
    for key in ("payload", "armature"):
        if key in arm:
            found[key] = _ranged(arm[key], f"arm.{key}")
    return found


def _ranged(value: Any, path: str) -> Any:
    if is_interval(value):
        low, _, high = _ends(value, path)
        return low, high
    if isinstance(value, Mapping):
        return {key: _ranged(item, f"{path}.{key}") for key, item in value.items()}
    if isinstance(value, list):
        return [_ranged(item, f"{path}[{i}]") for i, item in enumerate(value)]
    return value


def _taken(value: Any, path: str, axes: dict[str, Any]) -> Any:
    if is_interval(value):
        low, middle, high = _ends(value, path)
        if high > low:
            axes[path] = {"normal": [middle, (high - low) / (2.0 * _WIDTH)], "at_least": low, "at_most": high}
        return middle
    if isinstance(value, Mapping):
        return {key: _taken(item, f"{path}.{key}", axes) for key, item in value.items()}
    if isinstance(value, list):
        return [_taken(item, f"{path}[{i}]", axes) for i, item in enumerate(value)]
    return value


def _ends(value: Mapping[str, Any], path: str) -> tuple[float, float, float]:
    ends = [value["low"], value["value"], value["high"]]
    if (
        not all(isinstance(x, int | float) and not isinstance(x, bool) for x in ends)
        or not ends[0] <= ends[1] <= ends[2]
    ):
        raise ExperimentError(path, f"{dict(value)!r} given; expected numbers with low ≤ value ≤ high")
    return float(ends[0]), float(ends[1]), float(ends[2])


def _covers(given: str, path: str) -> bool:
    return path == given or path.startswith((f"{given}.", f"{given}[")) or given.startswith((f"{path}.", f"{path}["))


def _laid(own: Any, over: Any) -> Any:
    if isinstance(own, Mapping) and isinstance(over, Mapping) and not is_interval(over):
        return {**own, **{key: _laid(own.get(key), item) for key, item in over.items()}}
    return over
