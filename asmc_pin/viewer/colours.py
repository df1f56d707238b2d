"""One colour for each controller, the same in the replay, the figures and the tables."""

from __future__ import annotations

from collections.abc import Sequence

# Okabe and Ito (2008), Color Universal Design: told apart by colour-blind readers; neighbours far apart come first.
PALETTE = ("#0072B2", "#CC79A7", "#009E73", "#D55E00", "#56B4E9", "#E69F00", "#000000", "#8C564B")


def controller_colors(labels: Sequence[str]) -> dict[str, str]:
    """One colour for each controller, by its place in the experiment; the same in every figure and table."""
    return {label: PALETTE[i % len(PALETTE)] for i, label in enumerate(labels)}
