"""Experiments: TOML files that say which controllers follow which motion on which arm (docs/experiments.md)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from asmc_pin.lazy import load_on_first_use

if TYPE_CHECKING:
    from asmc_pin.experiment.files import experiment_names as experiment_names
    from asmc_pin.experiment.files import load_experiment as load_experiment
    from asmc_pin.experiment.jsonschema import experiment_schema as experiment_schema
    from asmc_pin.experiment.jsonschema import experiment_schema_text as experiment_schema_text
    from asmc_pin.experiment.laws import load_law as load_law
    from asmc_pin.experiment.model import Experiment as Experiment

load_on_first_use(
    __name__,
    {
        "Experiment": "model",
        "experiment_names": "files",
        "experiment_schema": "jsonschema",
        "experiment_schema_text": "jsonschema",
        "load_experiment": "files",
        "load_law": "laws",
    },
)

__all__ = [
    "Experiment",
    "experiment_names",
    "experiment_schema",
    "experiment_schema_text",
    "load_experiment",
    "load_law",
]
