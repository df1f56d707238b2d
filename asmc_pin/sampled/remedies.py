"""What would make an unstable sampled loop stable: one sentence per trouble, for `stability` and `compare` alike."""

from __future__ import annotations

from asmc_pin.sampled.critical_points import Critical
from asmc_pin.sampled.loop_limits import NOWHERE, Ends, gain_range, grid, stable_range
from asmc_pin.sampled.sampled_loop import SampledLoop
from asmc_pin.words.remedy_texts import MBAR_REMEDY
from asmc_pin.words.text import rounded_down, rounded_up

_FURTHEST = 1e4

ALTERNATION = "a torque that alternates from tick to tick goes on for ever, for it moves no angle at the ticks"
"""Why `SampledLoop.undamped_delay` is an end."""


def remedy(critical: Critical, loop: SampledLoop) -> str:
    """What a search found that helps an unstable loop; `critical` grows."""
    if loop.undamped_delay == 0.0:
        return f'{ALTERNATION}; pair the estimate with the mean of the last two (pairing = "mean")'
    gains = gain_range(critical, loop)
    if gains != NOWHERE:
        return (
            f"{'lower' if gains[1] <= 1.0 else 'raise'} β and K_s: {_stable(gains)} times these β and K_s with this M̄"
        )
    # A search on a grid: a narrow range may lie between two of its values.
    none = "no β and K_s in this proportion were found stable with this M̄"
    mbar = stable_range(critical, lambda x: loop.scaled(mbar=x), grid(1.0, 1.0 / _FURTHEST), grid(1.0, _FURTHEST))
    if mbar == NOWHERE:
        return f"{none}, nor these with any multiple of it: 'asmc-pin design --gains' looks for all three together"
    if mbar[1] <= 1.0:
        return f"{none}: {MBAR_REMEDY}; with these β and K_s it is {_stable(mbar)} times this M̄"
    return f"{none}; with these β and K_s it is {_stable(mbar)} times this M̄, which may break its condition"


def _stable(ends: Ends) -> str:
    low, high = ends
    if low == 0.0:
        return f"stable where searched up to {rounded_down(high, 3)}"
    if high == float("inf"):
        return f"stable where searched from {rounded_up(low, 3)}"
    return f"stable where searched from {rounded_up(low, 3)} to {rounded_down(high, 3)}"
