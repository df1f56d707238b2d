"""What the trials of a comparison say besides their figures: how sure these are, and where a law would have run."""

from __future__ import annotations

import numpy as np
import pandas as pd

from asmc_pin.arms.robot_limits import LIMITED_QUANTITIES
from asmc_pin.experiment import Experiment
from asmc_pin.metrics import METRICS
from asmc_pin.pages.tables.text_table import number
from asmc_pin.results.ensemble_summary import alike, failures, figures_by_trial, labels_of, sensitivity


def sensitivity_lines(experiment: Experiment, rows: pd.DataFrame) -> list[str]:
    """How far a start that nobody could tell apart moves the RMS error; nothing of a single trial.

    Args:
        experiment: As run.
        rows: Its summary.
    """
    trials, failed = rows.trial.nunique(), failures(rows).sum(axis=1)
    if trials == 1:
        return []
    if alike(rows):
        return [
            f"all {trials} trials are the same to the last bit, as nothing differs among them: how sure a figure is, "
            "is not known; give [ensemble] a q0_deviation"
        ]
    joints, told = list(dict.fromkeys(rows.joint)), []
    for label, moves, count in zip(labels_of(rows), sensitivity(rows, "rms_error"), failed, strict=True):
        if count and not np.isfinite(moves).all():
            told.append(f"{label} by more than can be said, as {count} of {trials} trials diverged")
        else:
            worst = int(np.argmax(moves))
            told.append(f"{label} by {number(100.0 * moves[worst], 2)} % ({joints[worst]})")
    return [
        f"numerical sensitivity for this plant and these gains: a start {experiment.ensemble.q0_deviation:g} rad away "
        f"moves the {METRICS['rms_error'].title} at the joint where it moves most, 5 % to 95 % of {trials} trials, of "
        + "; of ".join(told)
    ]


def limit_lines(experiment: Experiment, rows: pd.DataFrame) -> list[str]:
    """Which laws kept the limits of the robot that the experiment names; else would have run on one with that rate.

    A robot has more limits than are published or judged here, so of a named one no more is said than that.

    Args:
        experiment: As run.
        rows: Its summary.
    """
    robot = experiment.robot_limits
    if robot is None:
        limit = np.unique(experiment.metrics.torque_rate_limit)
        if not np.isfinite(limit).any():
            return []
        ran = np.all(figures_by_trial(rows, "torque_rate_ticks") == 0.0, axis=(1, 2))
        seen = rows.torque_rate_ticks > 0.0
        name, said = f"a {', '.join(f'{x:g}' for x in limit)} N·m/s robot", "torque rate: "
        kept = f"would have run on {name}"
    else:
        ran = np.all(np.isnan(figures_by_trial(rows, "trip_time")), axis=(1, 2))
        seen = np.isfinite(rows.trip_time)
        judged = [LIMITED_QUANTITIES[key][0] for key in robot.published]
        others = [words for words, _ in LIMITED_QUANTITIES.values() if words not in judged]
        missing = f" ({' and '.join(others)} not published, not judged)" if others else ""
        name, said = str(experiment.plant.limits), f"limits of {robot.robot}, {' and '.join(judged)}{missing}: "
        kept = "kept them"
    labels = np.array(labels_of(rows))
    parts = [f"{', '.join(labels[ran])} {kept} in every trial"] if ran.any() else []
    tripped = np.isin(labels, rows.controller[seen].astype(str))
    # A trial that diverged is worse than any figure, and yet it may have broken no limit.
    ended = ~ran & ~tripped
    parts += [f"{', '.join(labels[tripped])} would have tripped {name} in at least one trial"] if tripped.any() else []
    parts += [f"of {', '.join(labels[ended])} it is not known, as trials diverged"] if ended.any() else []
    return [said + "; ".join(parts)]
