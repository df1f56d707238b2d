"""The condition on M̄: evaluated (`norm`), searched (`search`), designed for (`best_mbar`), proven (`certificate`).

Takes an arm and M̄; gives verdicts with their hypotheses. What is proven is replayed by `checker`, which shares nothing
with the prover but the reader of its file. May import `arms` and `references`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from asmc_pin.lazy import load_on_first_use

if TYPE_CHECKING:
    from asmc_pin.condition.best_mbar.design_report import DesignReport as DesignReport
    from asmc_pin.condition.best_mbar.designing import design as design
    from asmc_pin.condition.certificate.search_and_proof import certified as certified
    from asmc_pin.condition.condition_report import ConditionReport as ConditionReport
    from asmc_pin.condition.domain.recorded_motion import Recording as Recording
    from asmc_pin.condition.domain.recorded_motion import read_recording as read_recording
    from asmc_pin.condition.domain.recorded_motion import tde_error as tde_error
    from asmc_pin.condition.inertia_bounds.bounding import bounds as bounds
    from asmc_pin.condition.inertia_bounds.bounds_report import Bound as Bound
    from asmc_pin.condition.inertia_bounds.bounds_report import BoundsReport as BoundsReport
    from asmc_pin.condition.norm.two_conditions import CONDITIONS as CONDITIONS
    from asmc_pin.condition.norm.two_conditions import Condition as Condition
    from asmc_pin.condition.norm.two_conditions import lemma1_norm as lemma1_norm
    from asmc_pin.condition.norm.two_conditions import weighted_norm as weighted_norm
    from asmc_pin.condition.search.norm_maps import Heatmap as Heatmap
    from asmc_pin.condition.search.norm_maps import heatmap as heatmap
    from asmc_pin.condition.search.worst_of_arm import scale_refuted as scale_refuted
    from asmc_pin.condition.search.worst_of_arm import search_worst as search_worst
    from asmc_pin.condition.verifying import verify as verify

__getattr__, __dir__, __all__ = load_on_first_use(__name__)
