"""A tuning of a second: two joints, a load and a move that differ from draw to draw, two controllers."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

from asmc_pin.experiment import Experiment

DATA: dict[str, Any] = {
    "name": "small",
    "arm": {"source": "two_link", "payload": 0.5},
    "period": 0.002,
    "duration": 0.2,
    "seed": 5,
    "plant": {"friction": {"coulomb": [1.0, 0.5], "viscous": 0.1}},
    "reference": {"kind": "quintic", "start": [0.3, 0.2], "targets": [[0.35, 0.15]], "move": 0.15},
    "tune": {"train": 2, "held_out": 6},
    "defaults": {"mbar": [0.02, 0.01], "ks": 5.0, "beta": 4.0},
    "controllers": {"PPC": {"law": "ppc"}, "BSMC": {"law": "bsmc", "gain": 5.0, "boundary": 0.05}},
    "sweep": {"arm.payload": {"uniform": [0.0, 2.0]}, "reference.move": {"uniform": [0.12, 0.18]}},
}


def small(**changes: Any) -> Experiment:
    """The experiment, with other keys at the top."""
    return Experiment.from_dict(copy.deepcopy(DATA) | changes)


def repeatable(folder: Path) -> dict[str, bytes]:
    """Every file of a tuning but its provenance and journals, which alone have times in them."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != "provenance.json" and path.parent.name != "studies"
    }
