"""Monitors of several controllers as tidy rows and as arrays with names and units."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr

from asmc_pin.monitors.claim_texts import CAUSES
from asmc_pin.monitors.monitor_record import Monitors

# Variable: its name in `Monitors`, meaning, unit (of revolute joints; 2-norms mix units on an arm with both kinds).
_PER_JOINT: Mapping[str, tuple[str, str, str]] = {
    "tde_error": ("error", "TDE error N, Gamma minus its estimate", "rad/s2"),
    "gain": ("gain", "switching gain", "rad/s2"),
    "gain_bound": ("gain_bound", "what the gain may be by (12) and (16)", "rad/s2"),
}
_PER_TICK: Mapping[str, tuple[str, str, str]] = {
    "lemma1_norm": ("norm", "Lemma 1: 2-norm of I - inv(M) Mbar", "1"),
    "tde_growth": ("growth", "change of the 2-norm of N since the last tick", "rad/s2"),
    "tde_carried": ("carried", "what is left of the last N after (I - inv(M) Mbar)", "1"),
    "lyapunov": ("lyapunov", "Lyapunov function (12)", "rad2/s2"),
    "excess": ("excess", "dV/dt + beta s's; (16) says at most 0 where claimed", "rad2/s3"),
    "s_norm": ("s_size", "2-norm of s", "rad/s"),
    "claimed": ("claimed", "whether (16) speaks of the period: the largest |s| at or above epsilon at both ends", "1"),
}
_PER_TRIAL: Mapping[str, tuple[str, str, str]] = {
    "s_bound": ("s_bound", "bound (21) of the 2-norm of s", "rad/s"),
    "t_eps": ("t_eps", "first time with the largest |s| below epsilon", "s"),
}


def claim_rows(monitors: Mapping[str, Monitors]) -> pd.DataFrame:
    """One row for each controller, trial and claim.

    Args:
        monitors: By the controllers' labels.

    Returns:
        Columns controller, trial, claim (key of `STATEMENTS`), title, statement, status, checked and broken (ticks),
        first_time, worst_time (s), amount with its unit, one column of broken ticks for each cause, until (s; when the
        trial diverged, else NaN), reason.
    """
    rows = [
        {
            "controller": label,
            "trial": claim.trial,
            "claim": claim.key,
            "title": claim.statement.title,
            "statement": claim.statement.text,
            "status": claim.status,
            "checked": claim.checked,
            "broken": claim.broken,
            "first_time": claim.first_time,
            "worst_time": claim.worst_time,
            "amount": claim.amount,
            "unit": claim.statement.unit,
            **{cause: claim.causes.get(cause, 0) for cause in CAUSES},
            "until": claim.until,
            "reason": claim.reason,
        }
        for label, item in monitors.items()
        for claim in item.claims
    ]
    return pd.DataFrame(rows)


def monitor_dataset(monitors: Mapping[str, Monitors]) -> xr.Dataset:
    """The arrays of several controllers on the same reference; dimensions controller, trial, time, joint.

    Args:
        monitors: By the controllers' labels.
    """
    items = list(monitors.values())
    dims = ("controller", "trial", "time", "joint")
    tables = ((_PER_JOINT, dims), (_PER_TICK, dims[:3]), (_PER_TRIAL, dims[:2]))
    values = {}
    for names, axes in tables:
        for name, (field, meaning, unit) in names.items():
            stacked = np.stack([np.asarray(getattr(item, field), dtype=np.float64) for item in items])
            values[name] = (axes, stacked, {"long_name": meaning, "units": unit})
    star = np.stack([item.star for item in items])
    about = {"long_name": "largest |N| of the run", "units": "rad/s2"}
    values["tde_error_bound"] = (("controller", "trial", "joint"), star, about)
    return xr.Dataset(
        values,
        coords={
            "controller": np.array(list(monitors), dtype=object),
            "trial": np.arange(len(items[0].star)),
            "time": ("time", items[0].time, {"long_name": "control tick", "units": "s"}),
            "joint": np.array(items[0].joint_names, dtype=object),
        },
    )
