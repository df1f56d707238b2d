"""Verify, design and compare time-delay-estimation control of robot arms on a Pinocchio ground truth.

The public names load on first use, so that importing the package, or asking the command line for help, stays quick.
"""

from __future__ import annotations

from asmc_pin.lazy import load_on_first_use

TYPE_CHECKING = False  # without the cost of importing typing

if TYPE_CHECKING:
    from asmc_pin.arms import Arm as Arm
    from asmc_pin.arms import load_arm as load_arm
    from asmc_pin.condition import ConditionReport as ConditionReport
    from asmc_pin.condition import DesignReport as DesignReport
    from asmc_pin.condition import design as design
    from asmc_pin.condition import lemma1_norm as lemma1_norm
    from asmc_pin.condition import verify as verify
    from asmc_pin.controllers import CONTROLLERS as CONTROLLERS
    from asmc_pin.controllers import Controller as Controller
    from asmc_pin.controllers import Sample as Sample
    from asmc_pin.controllers import Setpoint as Setpoint
    from asmc_pin.errors import AsmcPinError as AsmcPinError
    from asmc_pin.experiment import Experiment as Experiment
    from asmc_pin.experiment import load_experiment as load_experiment
    from asmc_pin.plant import Plant as Plant
    from asmc_pin.rollout import Rollout as Rollout
    from asmc_pin.rollout import rollout as rollout
    from asmc_pin.study.compare import compare as compare
    from asmc_pin.study.comparison import Comparison as Comparison

load_on_first_use(
    __name__,
    {
        "Arm": "arms",
        "AsmcPinError": "errors",
        "CONTROLLERS": "controllers",
        "Comparison": "study",
        "ConditionReport": "condition",
        "DesignReport": "condition",
        "Controller": "controllers",
        "Experiment": "experiment",
        "Plant": "plant",
        "Rollout": "rollout",
        "Sample": "controllers",
        "Setpoint": "controllers",
        "compare": "study",
        "design": "condition",
        "lemma1_norm": "condition",
        "load_arm": "arms",
        "load_experiment": "experiment",
        "rollout": "rollout",
        "verify": "condition",
    },
)

__all__ = [  # noqa: RUF022 - grouped as design and docs do
    "Arm",
    "load_arm",
    "ConditionReport",
    "lemma1_norm",
    "verify",
    "DesignReport",
    "design",
    "CONTROLLERS",
    "Controller",
    "Sample",
    "Setpoint",
    "Plant",
    "Rollout",
    "rollout",
    "Experiment",
    "load_experiment",
    "Comparison",
    "compare",
    "AsmcPinError",
]
