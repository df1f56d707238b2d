"""Experiments with one controller each, and exports of them, for the tests of exported code."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

from law_settings import HELD
from needs import program

from asmc_pin.codegen import Exported, export
from asmc_pin.codegen.c_compiler import EXACT, STRICT
from asmc_pin.controllers import CONTROLLERS
from asmc_pin.experiment import Experiment

LAWS = [name for name, law in CONTROLLERS.items() if law.trial_step is not None]
"""Laws with a step for one trial: those that can be exported."""

KINDS: dict[str, dict[str, Any]] = {
    **{name: {"law": name, **HELD.get(name, {})} for name in LAWS if name in HELD or name in ("ppc", "pid")},
    "by position": {"law": "ppc", "acceleration": "position"},
    "filtered": {"law": "bsmc", **HELD["bsmc"], "filter_hz": 80.0},
    "implicit plestan2010": {"law": "plestan2010", **HELD["plestan2010"], "switching": "implicit", "share": 0.3},
    "implicit baek2016": {"law": "baek2016", **HELD["baek2016"], "switching": "implicit"},
    "constant epsilon": {"law": "plestan2010", **HELD["plestan2010"], "epsilon": 0.02},
    "adaptive sta": {"law": "sta", **HELD["sta"], "rate": 2.0},
    "pid by position": {"law": "pid", "acceleration": "position", "filter_hz": 200.0},
    "deadbeat": {"law": "adrc", "observer_hz": float("inf")},
}
"""Every law with the gains that hold a mass, and the ways of computing that a law chooses between."""


def experiment_of(controller: dict[str, Any], **changes: Any) -> Experiment:
    """A short motion of two links with friction, with one controller, ``It``."""
    return Experiment.from_dict(
        {
            "name": "short",
            "arm": "two_link",
            "period": 0.001,
            "duration": 0.25,
            "ensemble": {"trials": 1},
            "plant": {"friction": {"coulomb": 1.0, "viscous": 0.1}, "effort_limit": [40.0, 15.0]},
            "reference": {
                "kind": "multisine",
                "offset": [0.3, 0.2],
                "amplitude": [[0.3], [0.2]],
                "frequency": [[2.0], [3.0]],
            },
            "defaults": {"mbar": [0.05, 0.04], "ks": 8.0, "beta": 9.0},
            "controllers": {"It": controller},
            **changes,
        }
    )


def exported(folder: Path, controller: dict[str, Any], **options: Any) -> Exported:
    """An export of that experiment's controller."""
    return export(experiment_of(controller), "It", folder, **{"ramp": 0.02, **options})


def built(folder: Path, compiler: str, *flags: str, language: str = "c", name: str = "short_it") -> Path:
    """The runner of an export, compiled without a warning."""
    out = folder / f"run_{compiler.strip('+')}_{len(flags)}_{language.strip('+')}"
    standard = STRICT if language == "c" else ("-xc++", "-std=c++11", *STRICT[1:])
    files = [str(folder / f"{name}.c"), str(folder / f"{name}_runner.c")]
    command = [program(compiler), *standard, "-Werror", *EXACT, *flags, *files, "-o", str(out), "-xnone", "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return out


def ran(runner: Path, folder: Path, name: str = "short_it") -> str:
    """What a runner says of the recorded vectors; it has found nothing wrong."""
    command = [str(runner), str(folder / f"{name}_vectors.csv")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
