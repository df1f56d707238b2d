"""Experiments: TOML files that say which controllers follow which motion on which arm (docs/experiments.md)."""

from __future__ import annotations

from asmc_pin.experiment.files import experiment_names, load_experiment
from asmc_pin.experiment.jsonschema import experiment_schema, experiment_schema_text
from asmc_pin.experiment.laws import load_law
from asmc_pin.experiment.model import Experiment

__all__ = [
    "Experiment",
    "experiment_names",
    "experiment_schema",
    "experiment_schema_text",
    "load_experiment",
    "load_law",
]
