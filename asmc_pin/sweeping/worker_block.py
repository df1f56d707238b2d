"""What a worker does with a block, whoever started it: the rows as bytes, or what is wrong in words."""

from __future__ import annotations

import threading

from asmc_pin.errors import AsmcPinError
from asmc_pin.sweeping.block_rows import BlockRows
from asmc_pin.sweeping.sweep_key import sweep_key
from asmc_pin.sweeping.sweep_plan import SweepPlan

_built = threading.local()
"""What this thread has built for the sweep that it works at; threads of one worker share nothing."""


def run_block(plan: SweepPlan, block: range, *, elsewhere: bool = False) -> tuple[bytes, str | None]:
    """Run a block.

    Args:
        plan: The sweep.
        block: Its trials.
        elsewhere: Whether this may be another machine: code, libraries and the files that the experiment names are
            then held against the sweep's key before anything is run.

    Returns:
        The bytes of the block's rows, and what is wrong if something is: our errors do not travel between processes.
    """
    try:
        if getattr(_built, "key", None) != plan.key:
            if elsewhere and sweep_key(plan.experiment) != plan.key:
                return b"", "another version of Python, asmc_pin, a library or a file that the experiment names is here"
            _built.rows, _built.key = BlockRows(plan), plan.key
        rows: BlockRows = _built.rows
        return rows.parquet(block), None
    except AsmcPinError as error:
        return b"", str(error)
