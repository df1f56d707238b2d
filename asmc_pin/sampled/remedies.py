"""What mends a sampled loop that is unstable: one remedy for one trouble, whoever asks.

`stability` and the warnings before a run call the same function; it searches the same samples of the same arms, so that
they cannot advise different things.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.domain.joint_box import BoxLike
from asmc_pin.sampled.loop_limits import gain_grid
from asmc_pin.sampled.sampled_loop import SampledLoop
from asmc_pin.sampled.workspace_worst import Workspace, workspace_of
from asmc_pin.words.remedy_texts import MBAR_REMEDY

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

_SAMPLES = 128
_FINEST = 0.01  # of a joint's range
# Factors that are tried, a tenth of a decade apart and short to write, the nearest to 1 first.
_STEPS = (1.0, 1.25, 1.6, 2.0, 2.5, 3.2, 4.0, 5.0, 6.3, 8.0)
_UP = [*(step * 10.0**decade for decade in range(3) for step in _STEPS), 1000.0][1:]
_FACTORS = [x for up in _UP for x in (float(f"{1.0 / up:.2g}"), up)]


def quick_workspaces(
    arm: Arm, box: BoxLike = None, *, viscous: Array | None = None, seed: int = 0
) -> tuple[Workspace, Workspace | None]:
    """What a quick look at a loop searches: by inertia alone, and about rest under gravity where there is any."""
    free = workspace_of(arm, box, samples=_SAMPLES, seed=seed, viscous=viscous)
    heavy = (
        workspace_of(arm, box, samples=_SAMPLES, seed=seed, gravity=True, viscous=viscous)
        if np.any(arm.gravity_vector)
        else None
    )
    return free.thinned(_SAMPLES, _FINEST), None if heavy is None else heavy.thinned(_SAMPLES, _FINEST)


def remedy(arms: Sequence[Arm], loop: SampledLoop, *, viscous: Array | None = None, box: BoxLike = None) -> str:
    """What to do about a loop that is unstable somewhere, in words; what it names was searched and found stable.

    Args:
        arms: Every arm that the loop is to hold.
        loop: Gains and timing.
        viscous: Viscous friction that is counted on, shape (nv,), N·m·s/rad; None for none.
        box: Joint box; the arms' own by default.
    """
    pairs = [quick_workspaces(arm, box, viscous=viscous) for arm in arms]
    slowest = gain_grid(loop)[0]
    if any(free.worst(loop.scaled(ks=slowest, beta=slowest))[0] >= 1.0 for free, _ in pairs):
        return f"no β and K_s are stable with this M̄, the torque estimate diverges by itself: {MBAR_REMEDY}"
    looked = [workspace for pair in pairs for workspace in pair if workspace is not None]
    for factor in _FACTORS:
        if _stable(looked, loop.scaled(ks=factor, beta=factor)):
            way = "lower" if factor < 1.0 else "raise"
            return f"{way} β and K_s: at {factor:g} times these β and K_s no configuration searched is unstable"
    return (
        f"no multiple of these β and K_s from {_FACTORS[-2]:g} to {_FACTORS[-1]:g} was found stable: ask 'asmc-pin "
        "design --gains' for an M̄ and gains that suit"
    )


def _stable(workspaces: Sequence[Workspace], loop: SampledLoop) -> bool:
    """Whether no configuration searched is unstable; the samples are asked first, which costs less."""
    return all(item.radii(loop).max() < 1.0 for item in workspaces) and all(
        item.worst(loop)[0] < 1.0 for item in workspaces
    )
