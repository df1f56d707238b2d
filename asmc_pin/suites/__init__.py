"""Suites: every law tuned and judged on several arms and tasks under stated conditions (docs/bench.md).

Takes a suite's TOML file; gives performance profiles, ranks with intervals, and who fails where. May import all rooms
but `reproduction` and `cli`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from asmc_pin.lazy import load_on_first_use

if TYPE_CHECKING:
    from asmc_pin.suites.bench_result import Benchmark as Benchmark
    from asmc_pin.suites.bench_verb import bench as bench

__getattr__, __dir__, __all__ = load_on_first_use(__name__)
