"""What is proven, one positivity statement at a time; `statement_forms` has what each kind says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from asmc_pin._typing import Array

Kind = Literal["weighted", "bounded", "lemma1", "level"]


@dataclass(frozen=True, eq=False)
class Statement:
    """One positivity statement.

    Attributes:
        kind: See `statement_forms`.
        scale: f.
        level: γ; 1 for the condition itself.
        case: Index of the arm among those of the certificate (payload ends, locked joints).
        armature: Shape (nv,), kg·m².
        slack: Range of the armature that the statement covers beyond `armature`, shape (nv,), kg·m².
    """

    kind: Kind
    scale: float
    level: float
    case: int
    armature: Array
    slack: Array
