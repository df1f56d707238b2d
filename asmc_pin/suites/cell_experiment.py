"""The experiment of one cell: one law on one arm in one task of a suite, with what `tune` needs to know."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

from asmc_pin.experiment import Experiment
from asmc_pin.suites.suite_reading import Suite

_APART = (1.0, 1.7)  # phases of two neighbouring joints, rad, of the slow and of the quick sine
_RISE = 0.8  # s


def cell_experiment(suite: Suite, arm: str, task: str, law: str) -> Experiment:
    """What a cell runs. The draws are the same for every law, since they follow from seed and keys alone.

    Raises:
        ExperimentError: the law refuses its parameters or the arm.
    """
    robot, asked, tables = suite.arms[arm], suite.tasks[task], suite.tables
    effort = robot["effort"]
    plant: dict[str, Any] = {
        **copy.deepcopy(dict(asked["plant"])),
        "effort_limit": effort,
        "friction": {name: [share * x for x in effort] for name, share in tables["friction"].items()},
    }
    if "push" in asked:
        begin, length = asked["push_time"]
        torque = [asked["push"] * x for x in effort]
        plant["disturbances"] = [{"profile": "pulse", "torque": torque, "start": begin, "duration": length}]
    if "set_down" in asked:
        plant["payload_changes"] = [{"time": asked["set_down"], "payload": 0.0}]
    data = {
        "name": f"{suite.name}-{arm}-{task}",
        "arm": {**robot["arm"], "payload": robot["payload"]},
        "period": tables["period"],
        "duration": asked["duration"],
        "seed": tables["seed"],
        "plant": plant,
        "reference": _motion(robot, asked),
        "tune": {
            "objective": tables["objective"],
            "limits": {"torque_noise": [tables["torque_noise"] * x for x in effort]},
            "train": tables["train"],
            "held_out": suite.held_out,
        },
        "sweep": copy.deepcopy(asked["vary"]),
        "defaults": {"mbar": robot["mbar"], **tables["defaults"]},
        "controllers": {law: dict(suite.laws[law])},
    }
    folder = suite.folders.get(law, Path.cwd())
    return Experiment.from_dict(data, folder=folder, origin=f"{suite.name}, {arm}, {task}")


def _motion(robot: Any, asked: Any) -> dict[str, Any]:
    """The reference: shares of the arm's swing about its home."""
    home, swing, share = robot["home"], robot["swing"], asked["share"]
    if asked["motion"] == "quintic":
        targets = [[x + part * y for x, y in zip(home, swing, strict=True)] for part in share]
        when = {"times": list(asked["times"]), "move": asked["move"]}
        return {"kind": "quintic", "start": home, "targets": targets, **when}
    return {
        "kind": "multisine",
        "offset": home,
        "amplitude": [[part * y for part in share] for y in swing],
        "frequency": [list(asked["frequency"]) for _ in swing],
        "phase": [[apart * i for apart in _APART] for i in range(len(swing))],
        "rise": _RISE,
    }
