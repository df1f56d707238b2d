"""Reading ``[sweep]``: its axes, and what is wrong with them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from asmc_pin.experiment.constructors import Mistake
from asmc_pin.experiment.variation.axes import Variation, VariedKey
from asmc_pin.experiment.variation.draws import DISTRIBUTIONS, is_finite, read_draw
from asmc_pin.experiment.variation.key_paths import MISSING, Parts, parts_of, value_at, with_value
from asmc_pin.metrics import METRICS
from asmc_pin.words.nearest_name import nearest

MOST_POINTS = 100_000
"""Of all grids together."""

_WAYS = (*DISTRIBUTIONS, "values", "scan")
_WITH_DRAW, _WITH_VALUES, _WITH_SCAN = ("at_least", "at_most", "each"), ("with",), ("until",)
_NOT_VARIED = {
    "name": "names the results",
    "seed": "decides all that is random, and every trial has its own from it",
    "trial": "is the number of a trial, and a sweep counts its own",
    "ensemble": "is about the last digits of one run",
    "sweep": "says what varies",
    "tune": "says how gains are searched",
    "log_every": "is about the files of a comparison, and a sweep's rows are of every tick",
}

Judge = Callable[[dict[str, Any]], list[Mistake]]
"""Every mistake in an experiment's tables."""


def variation_of(data: Mapping[str, Any]) -> Variation:
    """What varies in an experiment whose ``[sweep]`` has no mistakes."""
    tables = {key: value for key, value in data.items() if key != "sweep"}
    axes = tuple(axis for path in data.get("sweep", {}) if (axis := _read(path, data)[0]) is not None)
    return Variation(tables, axes, int(data.get("seed", 0)))


def sweep_problems(data: Mapping[str, Any], judge: Judge) -> list[Mistake]:
    """What is wrong with ``[sweep]``.

    Args:
        data: Tables of an experiment that is right without it.
        judge: Says what is wrong with the tables in which a key has one of its values; so an axis takes what the key
            itself takes, and an unknown one is found by the same checks.
    """
    table = data.get("sweep", {})
    if not isinstance(table, Mapping):
        return []  # the schema has said so
    plain = {key: value for key, value in data.items() if key != "sweep"}
    problems: list[Mistake] = []
    axes = []
    for path in table:
        found = _unknown_problems(path, plain, judge)
        if found:
            problems += found
            continue
        axis, found = _read(path, data)
        problems += found
        if axis is not None:
            axes.append(axis)
            problems += _value_problems(axis, plain, int(data.get("seed", 0)), judge)
    leaders = {axis.path: axis for axis in axes if axis.leading}
    for axis in axes:
        if axis.follows is not None:
            problems += _partner_problems(axis, leaders)
        for other in axes:
            if axis is not other and axis.parts == other.parts[: len(axis.parts)] and axis.follows != other.path:
                text = f"lies within '{axis.path}', which varies too; vary one of them"
                problems.append(Mistake(_key(other.path), text))
    if not problems and (points := Variation(plain, tuple(axes), 0).points) > MOST_POINTS:
        problems.append(Mistake("sweep", f"its grids have {points} points together; at most {MOST_POINTS}"))
    return problems


def _key(path: str) -> str:
    return f'sweep."{path}"'


def _read(path: str, data: Mapping[str, Any]) -> tuple[VariedKey | None, list[Mistake]]:
    """One line of the table, as far as it can be judged by itself."""
    key, given = _key(path), data["sweep"][path]
    parts = parts_of(path, data)
    if not parts or (isinstance(parts[0], str) and parts[0] in _NOT_VARIED):
        why = f"does not vary: it {_NOT_VARIED[str(parts[0])]}" if parts else "is no path of a key"
        return None, [Mistake(key, why)]
    if not isinstance(given, Mapping):
        return None, [Mistake(key, f"must be a table such as {{ uniform = [0.0, 1.0] }}, got {given!r}")]
    factor = "factor" in given
    inner = given["factor"] if factor else given
    if factor and (len(given) > 1 or not isinstance(inner, Mapping)):
        text = f"factor is the only key here, and a table such as {{ lognormal = 0.2 }}; got {dict(given)!r}"
        return None, [Mistake(key, text)]
    ways = [name for name in inner if name in _WAYS]
    if len(ways) != 1:
        got = f"got {' and '.join(ways)}" if ways else _advice(inner)
        return None, [Mistake(key, f"says how it varies by one of {', '.join(_WAYS)}; {got}")]
    way = ways[0]
    allowed = _WITH_VALUES if way == "values" else _WITH_SCAN if way == "scan" else _WITH_DRAW
    unknown = [name for name in inner if name != way and name not in allowed]
    if unknown:
        return None, [Mistake(f"{key}.{unknown[0]}", f"unknown key beside {way}: {nearest(unknown[0], allowed)}")]
    own = value_at(data, parts)
    if factor and not _all_numbers(own):
        state = "has no value in this file" if own is MISSING else f"is {own!r} in this file"
        return None, [Mistake(key, f"{path} {state}, and a factor needs a number or a list of numbers; give it one")]
    try:
        if way == "values":
            return _grid(path, parts, factor, inner), []
        if way == "scan":
            return VariedKey(path, parts, factor, scan=_ends(inner[way]), until=_until(inner.get("until", {}))), []
        draw = read_draw(inner, factor)
    except ValueError as error:
        return None, [Mistake(key, str(error))]
    needs = [f"{way} without its {DISTRIBUTIONS[way].split('[')[1].split(',')[0]}"] if draw.centre is None else []
    needs += ["each"] if draw.each else []
    if (draw.centre is None and not _all_numbers(own)) or (draw.each and not isinstance(own, list)):
        shape = "a list of numbers" if draw.each else "a number"
        return None, [Mistake(key, f"{' and '.join(needs)} starts from the file's own value; give {path} {shape}")]
    return VariedKey(path, parts, factor, draw=draw), []


def _advice(inner: Mapping[str, Any]) -> str:
    return f"'{next(iter(inner))}' is not known: {nearest(next(iter(inner)), _WAYS)}" if inner else "it says nothing"


def _all_numbers(value: Any) -> bool:
    return all(map(_all_numbers, value)) if isinstance(value, list) and value else is_finite(value)


def _grid(path: str, parts: Parts, factor: bool, table: Mapping[str, Any]) -> VariedKey:
    values, follows = table["values"], table.get("with")
    if not isinstance(values, list) or not values:
        raise ValueError(f"values takes a list of at least one; got {values!r}")
    if factor and not all(map(is_finite, values)):
        raise ValueError(f"factors are numbers; got {values!r}")
    if follows is not None and not isinstance(follows, str):
        raise ValueError(f"with takes the path of another grid; got {follows!r}")
    return VariedKey(path, parts, factor, values=tuple(values), follows=follows)


def _ends(given: Any) -> tuple[float, float]:
    if not isinstance(given, list) or len(given) != 2 or not all(map(is_finite, given)) or given[0] == given[1]:
        raise ValueError(f"scan takes two numbers, [start, end], which differ; got {given!r}")
    return float(given[0]), float(given[1])


def _until(given: Any) -> dict[str, float]:
    if not isinstance(given, Mapping):
        raise ValueError(f"until takes a table such as {{ max_error = 0.1 }}; got {given!r}")
    for name, limit in given.items():
        if name not in METRICS:
            raise ValueError(f"until: there is no metric '{name}': {nearest(name, METRICS)}")
        if not is_finite(limit):
            raise ValueError(f"until.{name} must be a number in SI units; got {limit!r}")
    return {name: float(limit) for name, limit in given.items()}


def _partner_problems(axis: VariedKey, leaders: Mapping[str, VariedKey]) -> list[Mistake]:
    leader = leaders.get(str(axis.follows))
    if leader is None:
        known = [name for name in leaders if name != axis.path]
        text = f"there is no grid '{axis.follows}' for it to go along with: {nearest(str(axis.follows), known)}"
        return [Mistake(f"{_key(axis.path)}.with", text)]
    if len(leader.values) != len(axis.values):
        text = f"has {len(axis.values)} values, and '{leader.path}', which it goes along with, {len(leader.values)}"
        return [Mistake(f"{_key(axis.path)}.values", text)]
    return []


def _unknown_problems(path: str, plain: dict[str, Any], judge: Judge) -> list[Mistake]:
    """Whether an experiment has such a key, told by what it says of one that stands there."""
    parts = parts_of(path, plain)
    if not parts or parts[0] in _NOT_VARIED:
        return []  # said where the line is read
    if parts[0] == "controllers" and len(parts) > 1 and parts[1] not in plain.get("controllers", {}):
        advice = nearest(str(parts[1]), plain.get("controllers", {}))
        return [Mistake(_key(path), f"there is no controller '{parts[1]}': {advice}")]
    own = value_at(plain, parts)
    try:
        tables = with_value(plain, parts, 1.0 if own is MISSING else own)
    except KeyError as error:
        return [Mistake(_key(path), f"there is no such key: {_no_place(parts[: int(error.args[0])], plain)}")]
    for found in judge(tables):
        if found.message.startswith(("unknown key", "unknown parameter", "no law takes")):
            return [Mistake(_key(path), f"there is no such key: {found.key}: {found.message}")]
    return []


def _no_place(parts: Parts, plain: dict[str, Any]) -> str:
    here = value_at(plain, parts)
    above = ".".join(map(str, parts))
    if here is MISSING:
        return f"'{above}' is not in this file; give it there"
    return f"'{above}' is " + (f"a list of {len(here)}, counted from [0]" if isinstance(here, list) else f"{here!r}")


def _value_problems(axis: VariedKey, plain: dict[str, Any], seed: int, judge: Judge) -> list[Mistake]:
    """What the experiment says of the values of an axis: all of a grid, the ends of a scan, the first draw."""
    hint = "; at_least and at_most bound what is drawn" if axis.draw is not None else ""
    try:
        quantities = list(axis.values) or list(axis.scan or ()) or [axis.drawn(plain, seed, 0)]
    except ValueError as error:
        return [Mistake(_key(axis.path), str(error))]
    for quantity in quantities:
        for found in judge(axis.placed(plain, quantity)):
            where = "" if found.key == axis.path else f"{found.key}: "
            return [Mistake(_key(axis.path), f"at {quantity!r}: {where}{found.message}{hint}")]
    return []
