"""Experiments: TOML files that say which controllers follow which motion on which arm (docs/experiments.md).

Takes a file or a dictionary; gives every mistake in it, or the arm, plant, reference and controllers. May import the
rooms that make these; steps no dynamics.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from asmc_pin.lazy import load_on_first_use

if TYPE_CHECKING:
    from asmc_pin.experiment.experiment import Experiment as Experiment
    from asmc_pin.experiment.finding import experiment_names as experiment_names
    from asmc_pin.experiment.finding import load_experiment as load_experiment
    from asmc_pin.experiment.json_schema import experiment_schema as experiment_schema
    from asmc_pin.experiment.json_schema import experiment_schema_text as experiment_schema_text
    from asmc_pin.experiment.law_lookup import load_law as load_law

__getattr__, __dir__, __all__ = load_on_first_use(__name__)
