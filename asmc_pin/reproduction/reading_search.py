"""Which reading of the paper's units and gains comes nearest to its tables and figures.

Only PPC and the proposed law take part, whose gains are printed: a baseline with free gains fits any row.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, cast

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.controllers import TdeLaw
from asmc_pin.engine import Rollout, rollout
from asmc_pin.experiment import Experiment
from asmc_pin.metrics import METRICS
from asmc_pin.plant import Friction, Plant
from asmc_pin.reproduction.printed_tables import PAPER, PPC, PROPOSED, Printed
from asmc_pin.reproduction.readings import ADAPTATION, ERRORS, FRICTION, MOTION, ReadingOutcome, as_read
from asmc_pin.study.stacked_settings import Stacked

_PRESLIDING_DAMPING = 10.0  # N·m·s/rad
_TOGETHER = ("motion", "start", "estimate")  # what trials of one rollout share


def outcomes(experiment: Experiment, wanted: Iterable[Mapping[str, str]]) -> list[ReadingOutcome]:
    """Run PPC and the proposed law of an experiment under every reading.

    Args:
        experiment: As printed.
        wanted: Readings; see `readings`.
    """
    wanted = list(wanted)
    groups: dict[tuple[str, ...], dict[tuple[str, ...], Mapping[str, str]]] = {}
    for reading in wanted:
        smoothed = FRICTION[reading["friction"]][1] > 0.0
        shared = (*(reading[axis] for axis in _TOGETHER), str(smoothed))
        groups.setdefault(shared, {})[_run_of(reading)] = reading
    measured: dict[tuple[str, ...], dict[str, Any]] = {}
    for members in groups.values():
        for label in (PPC, PROPOSED):
            rows = _measure(experiment, label, list(members.values()))
            for key, row in zip(members, rows, strict=True):
                measured.setdefault(key, {})[label] = row
    return [_outcome(reading, measured[_run_of(reading)], PAPER[experiment.name]) for reading in wanted]


def _run_of(reading: Mapping[str, str]) -> tuple[str, ...]:
    """Errors in deg or in rad are the same run."""
    return tuple(option for axis, option in reading.items() if axis != "errors")


def _measure(experiment: Experiment, label: str, members: Sequence[Mapping[str, str]]) -> list[dict[str, Any]]:
    """Figures of one law under readings that share motion, start and estimate; one rollout."""
    printed = PAPER[experiment.name]
    changed = _motion(experiment, MOTION[members[0]["motion"]])
    plant = changed.build_plant()
    law = cast(TdeLaw, changed.build_controllers()[label])
    run = rollout(
        Plant(
            plant.arms,
            substeps=plant.substeps,
            friction=_friction(plant, members),
            effort_limit=plant.effort_limit,
            start=cast(Any, members[0]["start"]),
        ),
        Stacked([as_read(law, reading) for reading in members], plant.nv),
        changed.build_reference(),
        printed.window or changed.duration,
        batch=len(members),
    )
    rms, torque, gain = (METRICS[name](run) for name in ("rms_error", "torque_max", "peak_gain"))
    return [
        {
            "ok": run.status[i] == "ok",
            "rms": np.degrees(rms[i]),
            "torque": float(np.max(torque[i])),
            "gain": float(np.max(gain[i])),
            "s": _largest_s(run, i, as_read(law, reading)),
        }
        for i, reading in enumerate(members)
    ]


def _friction(plant: Plant, members: Sequence[Mapping[str, str]]) -> Friction:
    """Friction of every trial; the files of the paper have Coulomb and viscous friction only."""
    chosen = [FRICTION[item["friction"]] for item in members]
    scale = np.array([[factor] for factor, _ in chosen])
    coulomb, viscous = plant.friction.coulomb * scale, plant.friction.viscous * scale
    if not any(travel for _, travel in chosen):
        return Friction(coulomb, viscous)
    # Presliding: a spring that reaches the Coulomb level over the travel, well damped.
    spring = coulomb / np.array([[travel] for _, travel in chosen])
    return Friction(coulomb, viscous, presliding=spring, presliding_damping=_PRESLIDING_DAMPING)


def _motion(experiment: Experiment, pace: float) -> Experiment:
    """A reference of the same kind inside the same range; gentler is slower."""
    reference = dict(experiment.reference)
    if reference["kind"] == "quintic":
        reference["move"] = reference["move"] / pace
    else:
        reference["frequency"] = [x * pace for x in reference["frequency"]]
    return experiment.replace(reference=reference)


def _largest_s(run: Rollout, trial: int, law: TdeLaw) -> Array:
    error = run.q_ref - run.q[trial]
    values: Array = np.max(np.abs(run.v_ref - run.v[trial] + law.ks * error), axis=0)
    return values


def _outcome(reading: Mapping[str, str], measured: Mapping[str, dict[str, Any]], printed: Printed) -> ReadingOutcome:
    unit = ERRORS[reading["errors"]]
    _, _, of_s, of_gain = ADAPTATION[reading["adaptation"]]
    law = measured[PROPOSED]
    rms = {label: tuple(unit * measured[label]["rms"]) for label in (PPC, PROPOSED)}
    torque, gain, s = law["torque"], law["gain"] * of_gain, tuple(law["s"] * of_s)
    distance = [
        math.log(found / told) ** 2
        for label in rms
        for found, told in zip(rms[label], printed.rms_deg[label], strict=True)
    ]
    axes = [(torque, printed.torque), (gain, printed.gain[PROPOSED]), *zip(s, printed.s, strict=True)]
    distance += [_beside(found, told) for found, told in axes]
    if not all(item["ok"] for item in measured.values()):
        distance = [math.inf] * len(distance)
    return ReadingOutcome(reading, rms, torque, gain, s, tuple(distance))


def _beside(found: float, axis: float) -> float:
    """How far a largest value is from one that fills half to all of an axis."""
    if not found > 0.0:
        return math.inf
    return math.log(found / axis) ** 2 if found > axis else min(0.0, math.log(2.0 * found / axis)) ** 2


def factor(parts: Iterable[ReadingOutcome]) -> float:
    """By which factor a figure is off, typically: exp of the root mean square of the logarithms."""
    logs = [x for part in parts for x in part.distance]
    return math.exp(math.sqrt(sum(logs) / len(logs))) if all(map(math.isfinite, logs)) else math.inf


def nearest_readings(
    candidates: Sequence[tuple[ReadingOutcome, ...]], printed: Sequence[Printed]
) -> list[tuple[ReadingOutcome, ...]]:
    """For each number of departures from what is printed, the reading that comes nearest.

    Out of the running is what needs more than twice the torque that the figures show: there no unit is left to be
    mistaken.

    Args:
        candidates: Readings; each with its outcome on every experiment that shares the gains.
        printed: These experiments.
    """
    best: dict[int, tuple[ReadingOutcome, ...]] = {}
    for parts in candidates:
        if any(part.torque > 2.0 * told.torque for part, told in zip(parts, printed, strict=True)):
            continue
        number = parts[0].departures
        if number not in best or factor(parts) < factor(best[number]):
            best[number] = parts
    return [best[number] for number in sorted(best)]


def reconciled(ladder: Sequence[tuple[ReadingOutcome, ...]]) -> tuple[ReadingOutcome, ...]:
    """The reading that is taken: every departure has to halve the factor at least, or it is not worth its while."""

    def score(parts: tuple[ReadingOutcome, ...]) -> float:
        return factor(parts) * 2.0 ** parts[0].departures

    return min(ladder, key=score)
