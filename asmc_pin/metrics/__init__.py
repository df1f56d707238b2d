"""What a comparison measures: each metric once, with its formula, unit and source (docs/metrics.md).

Takes a rollout; gives one number per trial and joint. Metrics are computed from what the plant did, never from what a
controller says of itself. May import numpy, the engine's record of a run and what is open to all.
"""

# In the order of the tables: a metric is registered when its file is imported.
from asmc_pin.metrics import tracking_metrics as tracking_metrics  # isort: skip
from asmc_pin.metrics import torque_metrics as torque_metrics  # isort: skip
from asmc_pin.metrics import robot_trips as robot_trips  # isort: skip
from asmc_pin.metrics import law_metrics as law_metrics  # isort: skip
from asmc_pin.metrics.metric_registry import (
    METRICS,
    MOVED,
    QUANTITIES,
    Best,
    Metric,
    MetricSettings,
    TripLimits,
    evaluate,
)
from asmc_pin.metrics.robot_trips import Trip, first_trip

__all__ = [
    "METRICS",
    "MOVED",
    "QUANTITIES",
    "Best",
    "Metric",
    "MetricSettings",
    "Trip",
    "TripLimits",
    "evaluate",
    "first_trip",
]
