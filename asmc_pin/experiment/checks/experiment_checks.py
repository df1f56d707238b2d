"""What is wrong with an experiment, as a list: nothing here raises, so that one run shows every mistake."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, get_args

import numpy as np
from pydantic import BaseModel, ValidationError

from asmc_pin._typing import Array
from asmc_pin.arms import Arm
from asmc_pin.errors import ExperimentError, ParameterError
from asmc_pin.experiment.constructors import Mistake, Signature, construct
from asmc_pin.experiment.named_robot import robot_problems
from asmc_pin.experiment.plant_parts import TABLES
from asmc_pin.experiment.toml_keys import ExperimentTables
from asmc_pin.references import REFERENCES, Reference
from asmc_pin.words.nearest_name import nearest
from asmc_pin.words.text import printable
from asmc_pin.words.units import check_delay, check_motion

_LOOKS = 2001
"""Instants of a reference at which its units are looked at."""


def table_problems(error: ValidationError) -> list[Mistake]:
    """Pydantic's findings in our words: the key's path, what was given, the nearest known key."""
    problems = []
    for item in error.errors(include_url=False):
        if item["loc"] == ("controllers", "law"):
            continue  # `controller_problems` knows what was meant
        path, model = _locate(item["loc"])
        last = str(item["loc"][-1]) if item["loc"] else ""
        given = printable(repr(item["input"]))
        if item["type"] == "extra_forbidden":
            message = f"unknown key: {nearest(last, model.model_fields)}"
        elif item["type"] == "missing":
            message = "is missing"
        elif item["type"] == "string_pattern_mismatch":
            message = f"got {given}; expected letters, digits, '.', '_' and '-', starting with a letter or digit"
        elif item["type"] in ("model_type", "dict_type"):
            message = f"must be a table, got {given}"
        elif item["type"] == "value_error":
            message = str(item["ctx"]["error"])
        else:
            text = item["msg"].removeprefix("Input ")
            message = f"{text[:1].lower()}{text[1:]}, got {given}"
        problems.append(Mistake(path, message))
    return problems


def _locate(loc: Sequence[str | int]) -> tuple[str, type[BaseModel]]:
    """Path in the file, and the table that holds its last key; pydantic's own tags of types are left out."""
    model: type[BaseModel] = ExperimentTables
    path = ""
    for depth, part in enumerate(loc):
        if isinstance(part, int):
            path += f"[{part}]"
            continue
        path = f"{path}.{part}" if path else part
        field = model.model_fields.get(part)
        inner = _model_of(field.annotation) if field is not None else None
        if inner is not None and depth + 1 < len(loc):
            model = inner
    return path, model


def _model_of(annotation: Any) -> type[BaseModel] | None:
    for kind in (annotation, *get_args(annotation)):
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            return kind
    return None


def reference_problems(table: Any, folder: Path) -> tuple[Any, list[Mistake]]:
    """The reference that a ``[reference]`` table describes, and what is wrong with the table."""
    if not isinstance(table, Mapping):
        return None, []  # the schema has said so
    if "kind" not in table:
        return None, [Mistake("reference.kind", f"is missing; one of {', '.join(REFERENCES)}")]
    kind = table["kind"]
    if not isinstance(kind, str) or kind not in REFERENCES:
        return None, [Mistake("reference.kind", f"there is no kind {kind!r}: {nearest(str(kind), REFERENCES)}")]
    cls = REFERENCES[kind]
    signature = Signature(cls)
    values = {key: value for key, value in table.items() if key != "kind"}
    problems = [
        Mistake(f"reference.{key}", f"unknown key of kind '{kind}': {nearest(key, signature.names)}")
        for key in values
        if not signature.takes(key)
    ]
    if problems:
        return None, problems
    if isinstance(values.get("path"), str):
        values["path"] = str(folder / values["path"])  # an absolute one stays as it is
    return construct(cls, values, "reference")


def delay_problems(data: Mapping[str, Any]) -> list[Mistake]:
    """Delays of the drive and the sensor, in periods, that look like seconds."""
    period, plant = data.get("period"), data.get("plant")
    problems = []
    for part in ("drive", "sensor"):
        table = plant.get(part) if isinstance(plant, Mapping) else None
        delay = table.get("delay") if isinstance(table, Mapping) else None
        if isinstance(period, int | float) and period > 0.0 and isinstance(delay, int | float):
            problems += _asked(f"plant.{part}.delay", check_delay, delay, period)
    return problems


def angle_problems(key: str, arm: Arm, q: Array) -> list[Mistake]:
    """Angles at which the arm is to stand, shape (nv,), that look like degrees."""
    return _asked(key, check_motion, key, arm, "it", np.zeros(1), q[None, :])


def motion_problems(reference: Reference, arm: Arm, duration: float) -> list[Mistake]:
    """A reference whose angles look like degrees."""
    time = np.linspace(0.0, duration, _LOOKS)
    motion = reference.evaluate(time)
    return _asked("reference", check_motion, "reference", arm, "it", time, motion.q, motion.v)


def _asked(key: str, check: Callable[..., None], *values: Any) -> list[Mistake]:
    try:
        check(*values)
    except ParameterError as error:
        return [Mistake(key, error.said)]
    return []


def plant_size_problems(tables: ExperimentTables, arm: Arm) -> list[Mistake]:
    """Lists of ``[plant]`` and ``[metrics]`` whose length is not the number of the arm's joints."""
    plant = tables.plant
    given = [(f"metrics.{name}", getattr(tables.metrics, name)) for name in ("settling_band", "torque_rate_limit")]
    given += [(f"plant.{name}", getattr(plant, name)) for name in ("effort_limit", "q0", "v0")]
    for key, cls in TABLES.items():
        signature, table = Signature(cls), getattr(plant, key) or {}
        given += [(f"plant.{key}.{name}", value) for name, value in table.items() if signature.per_joint(name)]
    return wrong_sizes(given, arm) + robot_problems(plant.limits, arm)


def wrong_sizes(given: Sequence[tuple[str, Any]], arm: Arm) -> list[Mistake]:
    """Lists, by their keys, that have not one value for each joint."""
    return [
        Mistake(key, f"{len(value)} values given, but {joints_of(arm)}")
        for key, value in given
        if isinstance(value, list) and len(value) != arm.nv
    ]


def joints_of(arm: Arm) -> str:
    """How many joints an arm has, and their names."""
    noun = "joint" if arm.nv == 1 else "joints"
    return f"{arm.name} has {arm.nv} {noun}: {', '.join(arm.joint_names)}"


def fail(problems: Sequence[Mistake], origin: str) -> None:
    """Raise an `ExperimentError` that lists all problems, one for each key; nothing if there is none."""
    if not problems:
        return
    problems = list({item.key: item for item in reversed(problems)}.values())[::-1]
    lines = [_line(item) for item in problems]
    text = f"{origin}: {lines[0]}" if len(lines) == 1 else "\n  ".join([f"{origin}: {len(lines)} mistakes", *lines])
    error = ExperimentError("", text)
    error.key = problems[0].key
    raise error


def _line(problem: Mistake) -> str:
    # A label or a key may hold a line break, which would look like a message of its own.
    message = problem.message.replace("\n", " ")
    return f"{printable(problem.key)}: {message}" if problem.key else message
