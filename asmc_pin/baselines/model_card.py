"""The card of a law that knows the model, made as the others are: asked of its own step, on a small arm."""

from __future__ import annotations

from typing import Any

from asmc_pin.arms import Arm, load_arm
from asmc_pin.baselines.model_law import BASELINES, ModelLaw
from asmc_pin.controllers.law_card import LawCard, card_of

ASKED = "two_link"
"""The arm whose model a law has when it is asked what it reads; the answer does not depend on it."""

LIMITS = "none that is the law's own: they follow from how good the model is"


def suggested_model_law(name: str, arm: Arm, **shared: Any) -> ModelLaw:
    """The law on a model of an arm, with the values that its card suggests."""
    law = BASELINES[name]
    return law(**{"period": 1e-3, **shared, **law.typical, "arm": arm})


def model_card(name: str) -> LawCard:
    """The card of a law of `BASELINES`."""
    arm = load_arm(ASKED)
    return card_of(name, suggested_model_law(name, arm), arm.nv, ("period",))
