"""What a design finds besides M̄: what limits it, what it trades for what, and what would make it better."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.words.text import printable


@dataclass(frozen=True, eq=False)
class DesignPoint:
    """One M̄, with the norm and the bandwidth that a search finds for it over the whole domain.

    Attributes:
        norm: Largest norm of the condition.
        bandwidth: Smallest λ_min(M⁻¹M̄): the slowest mode of the estimate converges by 1 − this per sample.
        mbar: Shape (nv,), kg·m².
    """

    norm: float
    bandwidth: float
    mbar: Array

    def to_json_dict(self) -> dict[str, Any]:
        """Its figures by name."""
        return {"norm": self.norm, "bandwidth": self.bandwidth, "mbar": self.mbar.tolist()}


@dataclass(frozen=True, eq=False)
class DesignBranch:
    """What the program of one branch on the base came to.

    Attributes:
        joints: The branch.
        norm: Largest norm of its block that a search found.
        bound: No M̄ has a smaller norm of this block, rigorously; 0 where λ_min(M⁻¹M̄) was the objective.
        bandwidth: Smallest λ_min(M⁻¹M̄) of its block that a search found.
    """

    joints: tuple[str, ...]
    norm: float
    bound: float
    bandwidth: float

    def to_json_dict(self) -> dict[str, Any]:
        """Its figures by name; no bound is None."""
        return {
            "joints": list(self.joints),
            "norm": self.norm,
            "bound": self.bound or None,
            "bandwidth": self.bandwidth,
        }

    def words(self) -> str:
        """Its norm, and whose."""
        return f"{self.norm:.6g} (joints {', '.join(printable(name) for name in self.joints)})"


@dataclass(frozen=True, eq=False)
class DesignLimit:
    """A configuration that keeps M̄ from being better.

    Attributes:
        q: Shape (nv,), rad (m where prismatic).
        share: Of all multipliers of the program; what limits most comes first.
        joint: The joint whose own inertia there would change most.
        side: ``small``: M̄ is too small for the inertia there. ``large``: it is too large.
        case: Which payload end or lock choice; empty without ranges.
    """

    q: Array
    share: float
    joint: str
    side: Literal["small", "large"]
    case: str

    def to_json_dict(self) -> dict[str, Any]:
        """All of it by name."""
        return {"q": self.q.tolist(), "share": self.share, "joint": self.joint, "side": self.side, "case": self.case}

    def words(self) -> str:
        """Where, how much it weighs, and what is wrong there."""
        case = f", {self.case}" if self.case else ""
        return (
            f"limited at q = {_listed(self.q)} ({self.share:.0%}{case}): M̄ is too {self.side} for the inertia that "
            f"joint '{printable(self.joint)}' has there"
        )


PUBLISHED_ROTORS = "the published rotors"


@dataclass(frozen=True, eq=False)
class ArmaturePurchase:
    """How far the least norm would fall if armature were added.

    Attributes:
        where: A joint, ``every joint``, or `PUBLISHED_ROTORS`.
        armature: Added, shape (nv,), kg·m².
        norm: Least norm that could then be designed.
    """

    where: str
    armature: Array
    norm: float

    def to_json_dict(self) -> dict[str, Any]:
        """All of it by name."""
        return {"where": self.where, "armature": self.armature.tolist(), "norm": self.norm}

    def words(self) -> str:
        """What it would buy."""
        if self.where == PUBLISHED_ROTORS:
            return (
                f"with the published rotors, {_listed(self.armature)} kg·m², a norm of {self.norm:.5g} would be "
                "possible: load the arm with armature 'published'"
            )
        return (
            f"armature of {_listed(self.armature)} kg·m² more on {printable(self.where)} would allow a norm of "
            f"{self.norm:.5g}"
        )


@dataclass(frozen=True, eq=False)
class WeightedDesign:
    """What the weighted condition would allow. It is not Lemma 1.

    Attributes:
        least: The M̄ of least weighted norm.
        scale: Factor by which the M̄ found for Lemma 1 could grow before the weighted condition breaks.
        scale_lemma1: The same before Lemma 1 breaks.
    """

    least: DesignPoint
    scale: float
    scale_lemma1: float

    def to_json_dict(self) -> dict[str, Any]:
        """The M̄ of least weighted norm, and the factors."""
        return {**self.least.to_json_dict(), "scale": self.scale, "scale_lemma1": self.scale_lemma1}

    def words(self) -> str:
        """What it would allow, and what it is not."""
        return (
            "the weighted condition, which is weaker and not Lemma 1, would allow a weighted norm of "
            f"{self.least.norm:.5g} with another M̄; this M̄ times {self.scale:.4g} breaks it, times "
            f"{self.scale_lemma1:.4g} breaks Lemma 1"
        )


def _listed(values: Array) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in np.where(np.abs(values) < 5e-5, 0.0, values)) + ")"
