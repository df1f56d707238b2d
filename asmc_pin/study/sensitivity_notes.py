"""What the trials of a comparison say besides their figures: how sure these are, and where a law would have run."""

from __future__ import annotations

import numpy as np
import pandas as pd

from asmc_pin.experiment import Experiment
from asmc_pin.metrics import METRICS
from asmc_pin.results.ensemble_summary import failures, figures_by_trial, labels_of, sensitivity


def sensitivity_lines(experiment: Experiment, rows: pd.DataFrame) -> list[str]:
    """How far a start that nobody could tell apart moves the RMS error; nothing of a single trial.

    Args:
        experiment: As run.
        rows: Its summary.
    """
    trials, failed = rows.trial.nunique(), failures(rows).sum(axis=1)
    if trials == 1:
        return []
    joints, told = list(dict.fromkeys(rows.joint)), []
    for label, moves, count in zip(labels_of(rows), sensitivity(rows, "rms_error"), failed, strict=True):
        if count and not np.isfinite(moves).all():
            told.append(f"{label} by more than can be said, as {count} of {trials} trials diverged")
        else:
            worst = int(np.argmax(moves))
            told.append(f"{label} by {100.0 * moves[worst]:.2g} % ({joints[worst]})")
    return [
        f"numerical sensitivity for this plant and these gains: a start {experiment.ensemble.q0_deviation:g} rad away "
        f"moves the {METRICS['rms_error'].title} at the joint where it moves most, 5 % to 95 % of {trials} trials, of "
        + "; of ".join(told)
    ]


def torque_rate_lines(experiment: Experiment, rows: pd.DataFrame) -> list[str]:
    """Which laws would have run on a robot that limits how fast its torque changes."""
    limit = np.unique(experiment.metrics.torque_rate_limit)
    if not np.isfinite(limit).any():
        return []
    ticks = figures_by_trial(rows, "torque_rate_ticks")
    ran = {True: [], False: []}  # type: dict[bool, list[str]]
    for label, own in zip(labels_of(rows), ticks, strict=True):
        ran[bool(np.all(own == 0.0))].append(label)
    robot = f"a {', '.join(f'{x:g}' for x in limit)} N·m/s robot"
    parts = [f"{', '.join(ran[True])} would have run on {robot} in every trial"] if ran[True] else []
    parts += [f"{', '.join(ran[False])} would have tripped {robot} in at least one trial"] if ran[False] else []
    return [f"torque rate: {'; '.join(parts)}"]
