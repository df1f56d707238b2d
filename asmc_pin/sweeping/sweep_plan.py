"""What a sweep is to do: its trials, the blocks that they are run in, and the columns of its rows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from numbers import Real
from pathlib import Path
from typing import Any

import pyarrow as pa

from asmc_pin.errors import ParameterError
from asmc_pin.experiment import Experiment
from asmc_pin.experiment.variation.axes import Variation
from asmc_pin.metrics import METRICS

BLOCK = 32
"""Trials of a block: enough for a batch to be cheap, few enough for both cores to be busy to the end."""

TOGETHER = 32
"""Trials of a block that are run at once: what a worker holds in memory does not grow with the block."""

MOST_TRIALS = 1_000_000_000
VARIED = "sweep."
"""How the columns begin that say what an axis stands at."""

SCANNED, PASSED, FAILS_AT = "scanned", "passed", "fails_at"
"""Columns of a scan: the key that is scanned, whether its start passed, and the smallest value seen to fail."""

TOOL = ("tool_rms_position", "tool_max_position", "tool_rms_rotation", "tool_max_rotation")
"""Columns of an experiment with ``metrics.tool``: as `compare` has them, m and rad, the same for all joints."""

KEY = b"asmc_pin.sweep"
"""Where a file of rows says which sweep it belongs to, among Parquet's own metadata."""


@dataclass(frozen=True)
class SweepPlan:
    """A sweep before it is run; travels to the workers.

    Attributes:
        tables: The experiment as TOML gives it, ``[sweep]`` included.
        folder: Where the experiment's relative paths are looked for.
        draws: Trials at each point.
        block: Trials that are run and written together.
        key: See `asmc_pin.sweeping.sweep_key.sweep_key`.
    """

    tables: Mapping[str, Any]
    folder: Path
    draws: int
    block: int
    key: str

    def __post_init__(self) -> None:
        for name, value in (("trials", self.draws), ("block", self.block)):
            if not isinstance(value, Real) or isinstance(value, bool) or value % 1 != 0 or value < 1:
                raise ParameterError(name, f"{value!r} given; expected a whole number, at least 1")
        if self.trials > MOST_TRIALS:
            raise ParameterError("trials", f"{self.trials} in all; at most {MOST_TRIALS} are numbered")

    def __getstate__(self) -> dict[str, Any]:
        """What travels: the tables, and nothing that was built of them here."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def experiment(self) -> Experiment:
        """The experiment, checked."""
        return Experiment.from_dict(self.tables, folder=self.folder)

    @cached_property
    def variation(self) -> Variation:
        """What varies."""
        return self.experiment.variation

    @property
    def trials(self) -> int:
        """All trials: draws times points."""
        return int(self.draws) * self.variation.points

    @property
    def blocks(self) -> list[range]:
        """Trials of each block."""
        return [range(start, min(start + self.block, self.trials)) for start in range(0, self.trials, int(self.block))]

    @property
    def schema(self) -> pa.Schema:
        """Columns of the rows: one row for each trial, controller and joint."""
        text, number, count = pa.string(), pa.float64(), pa.int64()
        columns = [("trial", count), ("draw", count), ("point", count), ("arm", text), ("controller", text)]
        columns += [("law", text), ("knows_model", pa.bool_()), ("joint", text), ("joint_kind", text)]
        columns += [("status", text), ("end_time", number)]
        columns += [(f"{VARIED}{axis.path}", number if axis.numeric else text) for axis in self.variation.axes]
        if self.variation.scans:
            columns += [(SCANNED, text), (PASSED, pa.bool_()), (FAILS_AT, number)]
        columns += [(name, number) for name in METRICS]
        if self.experiment.metrics.tool is not None:
            columns += [(name, number) for name in TOOL]
        return pa.schema(columns, metadata={KEY: self.key.encode()})


def sweep_plan(experiment: Experiment, draws: int, block: int | None, key: str) -> SweepPlan:
    """The plan of a sweep; see `SweepPlan`."""
    tables: dict[str, Any] = dict(experiment.variation.data)
    if experiment.sweep:
        tables["sweep"] = experiment.sweep
    plan = SweepPlan(tables, experiment.folder, draws, BLOCK if block is None else block, key)
    plan.__dict__["experiment"] = experiment  # made already
    return plan
