"""The condition along an experiment's motion, for those of its controllers that low-pass their whole estimate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from asmc_pin.arms import Arm
    from asmc_pin.condition import ConditionReport


@dataclass(frozen=True)
class LowPassedCondition:
    """What holds of one controller.

    Attributes:
        label: Of the controller.
        weight: c of its low-pass.
        report: On cM̄ along the motion.
    """

    label: str
    weight: float
    report: ConditionReport

    def to_json_dict(self) -> dict[str, Any]:
        """The figures by name."""
        found = self.report.to_json_dict()
        return {"weight": self.weight, **{key: found[key] for key in ("mbar", "verdict", "lower", "worst_q")}}

    def line(self) -> str:
        """In a sentence."""
        mbar = ", ".join(f"{value:.6g}" for value in self.report.mbar)
        return (
            f"controller {self.label} low-passes its estimate with c = {self.weight:.4g}, so its condition is that on "
            f"cM̄ = ({mbar}): {self.report.verdict}, norm to {self.report.lower:.6g} along the motion"
        )


def low_passed_conditions(motion: Any, arm: Arm, **options: Any) -> list[LowPassedCondition]:
    """One for each controller of an experiment with a low-pass on its whole estimate; none for other motions.

    Args:
        motion: An experiment, or something else that has a motion.
        arm: The arm.
        options: Of `verify`, along the motion.
    """
    from asmc_pin.condition import verify
    from asmc_pin.controllers import CONTROLLERS, TdeLaw
    from asmc_pin.experiment import Experiment

    if not isinstance(motion, Experiment):
        return []
    weighs = {name for name, law in CONTROLLERS.items() if law.estimate_weight is not TdeLaw.estimate_weight}
    tables = {label: table for label, table in motion.controllers.items() if table["law"] in weighs}
    if not tables:
        return []
    laws: dict[str, Any] = motion.replace(controllers=tables).build_controllers()
    found = []
    for label, law in laws.items():
        weight = float(law.estimate_weight)
        scaled = [weight * float(value) for value in law.for_joints(arm.nv).mbar]
        found.append(LowPassedCondition(label, weight, verify(arm, scaled, **options)))
    return found
