"""Experiments: shipped and small ones, shortened to some ticks, with a few things in them that are wrong."""

from __future__ import annotations

import copy
import json
import math
import tomllib
from pathlib import Path
from typing import Any

from fuzz.generate_urdf import sound, text
from fuzz.hostile import Rng, chance, mutate_bytes, mutate_tree, name, pick, scale_number, slots, value

MOST_TICKS = 100
TABLES: dict[str, list[dict[str, Any]]] = {
    "drive": [
        {"delay": 0.5, "current_hz": 100.0},
        {"gear": 100.0, "rotor_inertia": 1e-5, "stiffness": 1e4, "damping": 1.0, "backlash": 1e-3, "friction": "motor"},
        {"corner_speed": 2.0, "no_load_speed": 4.0, "velocity_limit": 3.0},
    ],
    "sensor": [
        {"bits": 15, "position_noise": 1e-5},
        {"resolution": 1e-5, "velocity": "filter", "filter_hz": 50.0, "delay": 0.5},
        {"velocity": "exact", "velocity_noise": 1e-3, "torque_noise": 0.1},
    ],
    "end_stops": [{}, {"stiffness": 1e4, "damping": 10.0}],
    "spread": [{"mass": 0.1, "com": 0.01, "inertia": 0.1, "friction": 0.1}],
    "friction": [
        {"coulomb": 1.0, "viscous": 0.1, "breakaway": 2.0, "stribeck_velocity": 0.05},
        {"coulomb": 1.0, "presliding": 1e4, "presliding_damping": 1.0},
    ],
}
LISTS: dict[str, list[dict[str, Any]]] = {
    "disturbances": [{"profile": "pulse", "torque": 1.0, "start": 0.005, "duration": 0.01}],
    "payload_changes": [{"time": 0.01, "payload": 0.5}],
}
LAWS: list[dict[str, Any]] = [
    {"law": "ppc"},
    {"law": "bsmc", "gain": 5.0, "boundary": 0.05},
    {"law": "plestan2010", "rate": 100.0, "epsilon": 0.1, "floor": 0.1},
    {"law": "baek2016", "phi": 800.0, "alpha": 0.03, "epsilon": 0.01},
    {"law": "computed_torque"},
    {"law": "pd_gravity", "kp": 100.0, "kd": 10.0},
]
STRANGERS: list[dict[str, Any]] = [{"law": "nowhere:Law"}, {"law": "canary:Law"}, {"law": "canary:None"}]
REFERENCES: list[dict[str, Any]] = [
    {"kind": "multisine", "offset": [0.3, 0.2], "amplitude": [[0.2], [0.2]], "frequency": [[0.5], [0.5]]},
    {"kind": "quintic", "start": [0.1, 0.2], "targets": [[0.12, 0.15]], "move": 0.05},
    {"kind": "ramps", "points": [[0.0, 0.1], [0.2, 0.3]], "times": [0.0, 0.02]},
    {"kind": "fourier", "offset": [0.0, 0.1], "a": [[0.1], [0.1]], "b": [[0.0], [0.1]], "base_hz": 0.5},
    {"kind": "csv", "path": "motion.csv"},
]
CSVS = (
    "t,q1,q2\n0,0,0.1\n0.01,0.01,0.1\n0.02,0.02,0.1\n0.05,0.05,0.1\n",
    "time,q_joint_1,q_joint_2,v1,v2,tau1,tau2\n0,0,0,0,0,1,1\n0.01,0,0,0,0,1,1\n0.02,0,0,0,0,1,1\n",
)


def law(rng: Rng) -> dict[str, Any]:
    """A law of the package, or one of a stranger's now and then."""
    return copy.deepcopy(pick(rng, STRANGERS if chance(rng, 0.06) else LAWS))


def small(rng: Rng) -> dict[str, Any]:
    """An experiment on the two-link arm with a reference, laws and parts of the plant that chance picks."""
    plant: dict[str, Any] = {"substeps": int(rng.integers(1, 4)), "effort_limit": 50.0}
    for key, tables in TABLES.items():
        if chance(rng, 0.2):
            plant[key] = copy.deepcopy(pick(rng, tables))
    for key, tables in LISTS.items():
        if chance(rng, 0.1):
            plant[key] = copy.deepcopy(tables)
    if chance(rng, 0.2):
        plant["integrator"] = str(pick(rng, ["semi_implicit", "midpoint", "rk4"]))
    labels = [name(rng) if chance(rng, 0.05) else f"Law {k}" for k in range(int(rng.integers(1, 3)))]
    return {
        "name": "small",
        "arm": "two_link" if chance(rng, 0.7) else {"source": "two_link", "payload": 1.0, "armature": [0.1, 0.2]},
        "period": 0.001,
        "duration": 0.02,
        "plant": plant,
        "reference": copy.deepcopy(pick(rng, REFERENCES)),
        "defaults": {"mbar": [0.01, 0.01], "ks": 5.0, "beta": 5.0},
        "controllers": {label: law(rng) for label in labels},
    }


def shorten(experiment: dict[str, Any]) -> None:
    """Keep a run at some ticks: a long one that was asked for is no fault. An absurd one stays, to be refused."""
    period, duration = experiment.get("period"), experiment.get("duration")
    numbers = (int, float)
    if isinstance(period, numbers) and isinstance(duration, numbers) and period > 0 and math.isfinite(period):
        ticks = duration / period
        if MOST_TICKS < ticks < 1e12:
            experiment["duration"] = 20 * period
    plant = experiment.get("plant")
    if isinstance(plant, dict) and isinstance(plant.get("substeps"), int) and plant["substeps"] > 10:
        plant["substeps"] = 10


def toml(tree: dict[str, Any]) -> str:
    """TOML of nested data, all tables inline, so that any of them can be written."""

    def text_of(word: str) -> str:
        return json.dumps(word).replace("\x7f", "\\u007f") if word.isascii() else json.dumps(word, ensure_ascii=False)

    def one(item: Any, depth: int = 0) -> str:
        if depth > 300:
            return "1"
        if isinstance(item, bool):
            return str(item).lower()
        if isinstance(item, dict):
            return "{" + ", ".join(f"{text_of(str(k))} = {one(v, depth + 1)}" for k, v in item.items()) + "}"
        if isinstance(item, list):
            return "[" + ", ".join(one(v, depth + 1) for v in item) + "]"
        if isinstance(item, str):
            return text_of(item)
        return '"none"' if item is None else repr(item)

    lines = [f"{text_of(k)} = {one(v)}" for k, v in tree.items() if k != "controllers" or not isinstance(v, dict)]
    controllers = tree.get("controllers")
    if isinstance(controllers, dict):
        for label, law in controllers.items():
            if isinstance(law, dict):
                lines.append(f"[controllers.{text_of(str(label))}]")
                lines += [f"{text_of(str(k))} = {one(v)}" for k, v in law.items()]
            else:
                lines.append(f"[controllers]\n{text_of(str(label))} = {one(law)}")
    return "\n".join(lines) + "\n"


def experiment(rng: Rng, corpus: list[bytes]) -> bytes:
    """One file."""
    tree = tomllib.loads(pick(rng, corpus).decode()) if chance(rng, 0.1) else small(rng)
    if chance(rng, 0.08) and isinstance(tree.get("arm"), str):
        tree["arm"] = "stranger.urdf"
    for _ in range(int(rng.choice([0, 0, 1, 1, 1, 2, 4]))):
        how = int(rng.integers(7))
        if how <= 3:
            scale_number(rng, tree)
        elif how == 4:
            mutate_tree(rng, tree)
        elif how == 5:
            table = pick(rng, [t for t, _ in slots(tree) if isinstance(t, dict)] or [tree])
            table[name(rng) if chance(rng, 0.5) else pick(rng, ["drive", "lock", "seed", "payload", "tool"])] = value(
                rng
            )
        elif isinstance(tree.get("controllers"), dict):
            tree["controllers"][name(rng)] = law(rng)
    shorten(tree)
    made = toml(tree).encode("utf-8", errors="surrogatepass" if chance(rng, 0.2) else "replace")
    return mutate_bytes(rng, made, pick(rng, corpus)) if chance(rng, 0.1) else made


_LAW = "class Law:\n    def init(self, sample): return 0\n    def step(self, state, sample, setpoint): return "
CANARIES = (
    *("", "raise SystemExit(5)", "raise KeyError('none')"),
    *(f"{_LAW}{torque}, 0" for torque in ("0 * sample.q", "1 / 0", "'no'", "float('nan') * sample.q", "exit(1)")),
    f"{_LAW}0 * sample.q, 0\n    def __init__(self): exit(3)",
)


def canary(rng: Rng, *folders: Path) -> None:
    """A module with a law that leaves a file behind when it is imported, and does something or other."""
    for folder in folders:
        (folder / "canary.py").write_text(f"open('imported', 'w').close()\n{pick(rng, CANARIES)}\n", encoding="utf-8")


def companions(rng: Rng, folder: Path) -> None:
    """What an experiment may name: a recording and a URDF."""
    recording = str(pick(rng, CSVS)).encode()
    (folder / "motion.csv").write_bytes(mutate_bytes(rng, recording) if chance(rng, 0.4) else recording)
    (folder / "stranger.urdf").write_text(text(rng, sound(rng, 2)), encoding="utf-8", errors="replace")


def make(rng: Rng, folder: Path, corpus: list[bytes]) -> list[str]:
    """Write an experiment into the folder; the command that is to read it.

    Args:
        rng: Where all chance comes from.
        folder: An empty folder, which will be the working directory.
        corpus: Sound experiments.
    """
    (folder / "x.toml").write_bytes(experiment(rng, corpus))
    companions(rng, folder)
    canary(rng, folder)
    if chance(rng, 0.25):
        arm = str(pick(rng, ["two_link", "two_link", "ur5", "stranger.urdf"]))
        what = "motion.csv" if chance(rng, 0.3) else "x.toml"
        words = ["verify", arm, "--mbar", "0.01", "--along", what]
    else:
        words = ["compare", "x.toml", "--out", str(pick(rng, ["x.toml", "."])) if chance(rng, 0.02) else "deep/made"]
        words += ["--force"] if chance(rng, 0.2) else []
        words += ["--refine"] if chance(rng, 0.05) else []
    return [*words, *(["--json"] if chance(rng, 0.6) else [])]
