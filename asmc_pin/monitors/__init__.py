"""The theorems of Baek (2016), and what other laws' sources claim, held against what only the plant knows.

docs/monitors.md explains them.

Takes a rollout, its plant and its law; gives verdicts with reasons and the arrays behind them. May import `condition`,
`plant`, `controllers` and the engine.
"""

from __future__ import annotations

from asmc_pin.monitors.claim_texts import BAEK, CAUSES, STATEMENTS, STATUSES, Claim, ClaimText
from asmc_pin.monitors.law_signals import gamma_at_ticks
from asmc_pin.monitors.monitor_record import Monitors, monitor
from asmc_pin.monitors.monitor_tables import claim_rows, monitor_dataset

__all__ = [
    "BAEK",
    "CAUSES",
    "STATEMENTS",
    "STATUSES",
    "Claim",
    "ClaimText",
    "Monitors",
    "claim_rows",
    "gamma_at_ticks",
    "monitor",
    "monitor_dataset",
]
