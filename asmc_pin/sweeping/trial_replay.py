"""One trial of a sweep again, with everything logged, as the result of a comparison with its page."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow.compute as pc
import pyarrow.parquet as pq

from asmc_pin.disk.reading import user_path
from asmc_pin.errors import ParameterError
from asmc_pin.experiment import Experiment
from asmc_pin.metrics import METRICS
from asmc_pin.study import Comparison, compare
from asmc_pin.sweeping.row_files import ROWS, key_of, shards_there
from asmc_pin.sweeping.sweep_key import sweep_key
from asmc_pin.sweeping.sweep_plan import FAILS_AT, TOOL, SweepPlan, sweep_plan
from asmc_pin.words.interface import flag_words


def replay(
    experiment: Experiment,
    trials: int,
    trial: int,
    out: str | Path | None = None,
    *,
    progress: Callable[[str, float], None] | None = None,
    warn: Callable[[str], None] | None = None,
) -> Comparison:
    """Run one trial of a sweep again and write trajectories, figures and a report.

    Where the sweep has its rows on disk, they are held against this run: the figures are the same to the last bit. A
    trial of a scan is run where the first controller failed in it, or at the scan's end if none did; that needs rows.
    Every tick is in its trajectories, whatever ``log_every`` says.

    Args:
        experiment: As swept.
        trials: Draws at each point, as swept.
        trial: Number of the trial.
        out: Folder of the sweep; ``results/NAME-sweep`` when omitted. The replay is its ``replay/TRIAL``.
        progress: See `asmc_pin.compare`.
        warn: See `asmc_pin.compare`.

    Raises:
        ParameterError: the sweep has no such trial.
        ExperimentError: see `sweep`.
        ResultError: the replay cannot be written.
    """
    folder = user_path(out) if out is not None else Path("results") / f"{experiment.name}-sweep"
    plan = sweep_plan(experiment, trials, None, sweep_key(experiment))
    if not 0 <= trial < plan.trials:
        raise ParameterError("replay", f"{trial} given; the trials of this sweep are 0 to {plan.trials - 1}")
    variation = plan.variation
    point, draw = variation.place_of(trial)
    quantities = variation.quantities(trial)
    axis = variation.scan_at(point)
    if axis is not None and axis.scan is not None:
        quantities[axis.path] = _failing(plan, folder, trial, axis.scan)
    tables = variation.tables(quantities)
    name = f"{experiment.name}-trial-{trial}"[-100:]
    alone = {"name": name, "trial": draw, "sweep": None, "ensemble": {"trials": 1}, "log_every": None}
    single = experiment.replace(**{**tables, **alone})
    made = compare(single, folder / "replay" / str(trial), force=True, progress=progress, warn=warn)
    if axis is None:
        _check_same(made, _rows_of(plan, folder, trial))
        if warn is not None and _others(plan, folder):
            warn(f"{folder} holds rows {_STALE}; this run is not held against them")
    return made


_STALE = "of another experiment, URDF or version"


def _others(plan: SweepPlan, folder: Path) -> bool:
    """Whether rows lie there that are another sweep's, so that a replay may well differ from them."""
    return any(key not in (plan.key, None) for key in shards_there(folder).values())


def _rows_of(plan: SweepPlan, folder: Path, trial: int) -> dict[str, list[object]] | None:
    """The rows of a trial on disk; None where this sweep has none."""
    files = [path for path, key in shards_there(folder).items() if key == plan.key]
    files = [path for path in files if int(path.stem[:9]) <= trial <= int(path.stem[-9:])]
    if (folder / ROWS).is_file() and key_of(folder / ROWS) == plan.key and not files:
        files = [folder / ROWS]
    if not files:
        return None
    table = pq.read_table(files[0])
    found: dict[str, list[object]] = table.filter(pc.equal(table["trial"], trial)).to_pydict()
    return found


def _failing(plan: SweepPlan, folder: Path, trial: int, scan: tuple[float, float]) -> float:
    """The value nearest to a scan's start at which a controller failed; the scan's end if none did."""
    rows = _rows_of(plan, folder, trial)
    if rows is None:
        there = f", only rows {_STALE}: sweep it again with {flag_words('force')}" if _others(plan, folder) else ""
        told = f"trial {trial} is a scan, and {folder} has no rows of this sweep that say where{there}"
        raise ParameterError("replay", told)
    ends = np.array(rows[FAILS_AT], dtype=np.float64)
    ends = ends[np.isfinite(ends)]
    return float(ends[np.argmin(np.abs(ends - scan[0]))]) if len(ends) else scan[1]


def _check_same(made: Comparison, rows: dict[str, list[object]] | None) -> None:
    """Whether the replay has the figures of the sweep; anything else is a fault of ours."""
    first = made.rows[made.rows.trial == 0]
    for name in () if rows is None else [each for each in (*METRICS, *TOOL) if each in rows]:
        assert rows is not None
        swept = np.array(rows[name], dtype=np.float64)
        if not np.array_equal(first[name].to_numpy(), swept, equal_nan=True):
            raise RuntimeError(f"the replay's {name} differs from the sweep's rows; they have to be the same bits")
