"""The condition on M̄: evaluated, searched, designed for."""

from __future__ import annotations

from asmc_pin.condition.certified import certified
from asmc_pin.condition.design import design
from asmc_pin.condition.design_report import DesignReport
from asmc_pin.condition.heatmap import Heatmap, heatmap
from asmc_pin.condition.lemma1 import CONDITIONS, Condition, lemma1_norm, weighted_norm
from asmc_pin.condition.recorded import Recording, read_recording, tde_error
from asmc_pin.condition.report import ConditionReport
from asmc_pin.condition.search import scale_refuted, search_worst
from asmc_pin.condition.verify import verify

__all__ = [
    "CONDITIONS",
    "Condition",
    "ConditionReport",
    "DesignReport",
    "Heatmap",
    "Recording",
    "certified",
    "design",
    "heatmap",
    "lemma1_norm",
    "read_recording",
    "scale_refuted",
    "search_worst",
    "tde_error",
    "verify",
    "weighted_norm",
]
