"""Laws that know the model, to compare with: a family of its own, marked as such wherever they appear.

Takes an arm, samples and set points; gives torque. They are the only laws that may see an arm; may import `arms`,
`controllers` and `parameters`.
"""

from __future__ import annotations

from asmc_pin.baselines.model_law import BASELINES, ModelLaw
from asmc_pin.controllers import LawInfo, describe_parameter, parameters_of

# Every law's file, in the order of the tables. The import is what registers the law.
# isort: off
from asmc_pin.baselines.computed_torque import ComputedTorque as ComputedTorque
from asmc_pin.baselines.pd_gravity import PdGravity as PdGravity
from asmc_pin.baselines.slotine_li import SlotineLi as SlotineLi
# isort: on

__all__ = [
    "BASELINES",
    "MARK",
    "ModelLaw",
    "baselines_table",
    "describe_baselines",
    "knows_model",
    "shown_label",
]

MARK = "knows the model"
"""What tables and figures say of them."""


def knows_model(law: object) -> bool:
    """Whether a law, or its class, computes with a model of the arm; one of the user's own says so by `knows_model`."""
    return bool(getattr(law, "knows_model", False))


def shown_label(label: str, law: object) -> str:
    """The label of a controller as results show it: marked if the law knows the model."""
    return f"{label} ({MARK})" if knows_model(law) else label


def baselines_table() -> list[dict[str, str]]:
    """One row per law, with the columns of `asmc_pin.controllers.controllers_table`."""
    return [
        {
            "law": law.name,
            "what": f"{law.title} ({MARK})",
            "equation": law.equation,
            "own parameters": ", ".join(map(str, law.parameters)),
            "source": law.reference,
        }
        for law in describe_baselines()
    ]


def describe_baselines() -> tuple[LawInfo, ...]:
    """Every law with its parameters, in the order of `BASELINES`; the period, which all laws share, is left out."""
    return tuple(
        LawInfo(
            name,
            law.title,
            law.equation,
            law.reference,
            tuple(describe_parameter(item) for key, item in parameters_of(law).items() if key != "period"),
        )
        for name, law in BASELINES.items()
    )
