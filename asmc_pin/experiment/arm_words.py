"""An experiment's arm in the words of the command line, for a command that asks about the same arm."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from asmc_pin.experiment.experiment import Experiment


def arm_words(experiment: Experiment) -> list[str]:
    """ARM and the options that make of it what the experiment simulates, with the rotors of its drives.

    What is told is the arm at the start; payloads that change later are not options of one arm.
    """
    return [experiment.arm.source, *_options(experiment)]


def mbar_words(experiment: Experiment, label: str) -> list[str]:
    """``--mbar`` of a controller as its file gives it; empty where its law has none."""
    mbar = {**experiment.defaults, **experiment.controllers[label]}.get("mbar")
    if mbar is None:
        return []
    return ["--mbar", ",".join(f"{float(value):.9g}" for value in np.atleast_1d(mbar))]


def _options(experiment: Experiment) -> Iterator[str]:
    table = experiment.arm
    if table.payload is not None:
        load = table.payload
        link = "" if load.link is None else f"@{load.link}"
        yield from ("--payload", f"{load.mass:g}{link}")
        for option, values in (("--payload-com", load.com), ("--payload-inertia", load.inertia)):
            if values is not None and np.any(values):
                yield from (option, ",".join(f"{value:g}" for value in np.ravel(values)))
    armature = experiment.build_plant().arm.armature
    if np.any(armature):
        yield from ("--armature", ",".join(f"{value:.9g}" for value in armature))
    for joint, angle in (table.lock or {}).items():
        yield from ("--lock", f"{joint}={angle}")
    if table.chain is not None:
        yield from ("--chain", ":".join(table.chain))
    if table.gravity is not None:
        yield from ("--gravity", ",".join(f"{value:g}" for value in table.gravity))
    if table.repair:
        yield "--repair"
    for option, pairs in (("--xacro", table.xacro), ("--package", table.package)):
        for name, value in (pairs or {}).items():
            yield from (option, f"{name}={value}")
    estimate = table.estimate_inertia
    if isinstance(estimate, dict):
        for link, mass in estimate.items():
            yield from ("--estimate-inertia", f"{link}={mass:g}")
    elif estimate is not None and math.isfinite(estimate):
        yield from ("--estimate-inertia", f"{estimate:g}")
