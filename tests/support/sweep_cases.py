"""A sweep of fractions of a second: two joints, noise and scatter, a grid and something drawn."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

from asmc_pin.experiment import Experiment

DATA: dict[str, Any] = {
    "name": "tiny",
    "arm": {"source": "two_link", "payload": 0.5},
    "period": 0.002,
    "duration": 0.1,
    "seed": 5,
    "plant": {
        "friction": {"coulomb": [1.0, 0.5], "viscous": 0.1},
        "sensor": {"position_noise": 1e-5},
        "spread": {"mass": 0.05},
    },
    "reference": {"kind": "quintic", "start": [0.3, 0.2], "targets": [[0.35, 0.15]], "move": 0.1},
    "defaults": {"mbar": [0.02, 0.01], "ks": 5.0, "beta": 4.0},
    "controllers": {"PPC": {"law": "ppc"}, "BSMC": {"law": "bsmc", "gain": 5.0, "boundary": 0.05}},
    "sweep": {
        "arm.payload": {"uniform": [0.0, 2.0]},
        "plant.friction.coulomb": {"factor": {"lognormal": 0.3, "each": True}},
        "defaults.mbar": {"factor": {"values": [0.5, 1.0]}},
    },
}


def tiny(sweep: dict[str, Any] | None = None, **changes: Any) -> Experiment:
    """The experiment, with another ``[sweep]`` and other keys at the top."""
    data = copy.deepcopy(DATA) | changes
    return Experiment.from_dict(data if sweep is None else {**data, "sweep": sweep})


def contents(folder: Path) -> dict[str, bytes]:
    """Every file of a sweep but its provenance, which alone has times in it, and its shards' division."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != "provenance.json"
    }
