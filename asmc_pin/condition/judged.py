"""What every verdict on M̄ says of what it is about, read off its hypotheses."""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.hypotheses import Condition, Hypotheses, Where
from asmc_pin.words.shown import Shown


class AboutMbar(Shown):
    """What is said of an M̄, or of there being none.

    Attributes:
        hypotheses: What it is about: arm, M̄, condition, armature, payload, locked joints, box.
    """

    hypotheses: Hypotheses

    @property
    def arm(self) -> str:
        """Name of the arm."""
        return self.hypotheses.arm

    @property
    def joints(self) -> tuple[str, ...]:
        """Its moving joints, base first."""
        return self.hypotheses.joints

    @property
    def condition(self) -> Condition:
        """``lemma1`` or ``weighted``."""
        return self.hypotheses.condition

    @property
    def formula(self) -> str:
        """The condition as an inequality, its level included."""
        return self.hypotheses.formula


class Judged(AboutMbar):
    """A verdict on M̄, searched or proven.

    Attributes:
        notes: What a reader has to know, in plain words.
    """

    notes: tuple[str, ...]

    @property
    def mbar(self) -> Array:
        """Diagonal of M̄, shape (nv,), kg·m²."""
        return np.array(self.hypotheses.mbar)

    @property
    def scope(self) -> Where:
        """Over what: ``box``, ``motion`` or ``tube``."""
        return self.hypotheses.where

    def remarks(self) -> list[str]:
        """What a reader has to know."""
        return [f"note: {line}" for line in self.notes]
