"""The norm over pairs of joints, as arrays for figures."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.domain.joint_box import Box, BoxLike, resolve_box
from asmc_pin.condition.norm.two_conditions import Condition, check_condition, check_mbar
from asmc_pin.condition.search.samples import NORM, figures_at, sample_box
from asmc_pin.errors import ParameterError

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

Others = Literal["held", "largest"]


@dataclass(frozen=True, eq=False)
class Heatmap:
    """The norm over two joints.

    Attributes:
        joints: The two, first the one of the horizontal axis.
        x: Values of the first, shape (nx,), rad (m where prismatic).
        y: Values of the second, shape (ny,).
        norms: Shape (ny, nx); NaN where ``largest`` had no sample.
        others: What the other joints do: ``held`` at a configuration, or ``largest`` over samples of them.
    """

    joints: tuple[str, str]
    x: Array
    y: Array
    norms: Array
    others: Others


def heatmap(
    arm: Arm,
    mbar: Any,
    first: str,
    second: str,
    *,
    condition: Condition = "lemma1",
    box: BoxLike = None,
    q: Array | None = None,
    armature: Array | None = None,
    others: Others = "held",
    resolution: int = 61,
    samples: int = 2**16,
    seed: int = 0,
) -> Heatmap:
    """The norm of a condition over two joints.

    Args:
        arm: The arm.
        mbar: Diagonal of M̄, one value or nv of them, kg·m².
        first: Joint of the horizontal axis.
        second: Joint of the vertical axis.
        condition: ``lemma1`` or ``weighted``.
        box: Joint box; see `BoxLike`.
        q: With ``held``: where the other joints stand, shape (nv,); default the middle of the box.
        armature: In place of the arm's own, shape (nv,), kg·m².
        others: ``held``, or ``largest``: over samples of the other joints, which shows where trouble can be at all.
        resolution: Values per axis.
        samples: With ``largest``: how many.
        seed: Of the samples.

    Returns:
        The map.

    Raises:
        ParameterError: An unknown joint, twice the same one, or a malformed option.
    """
    condition = check_condition(condition)
    values, domain = check_mbar(mbar, arm.nv), resolve_box(arm, box)
    for joint in (first, second):
        if joint not in arm.joint_names:
            raise ParameterError("joints", f"'{joint}' is not a joint of {arm.name}: {', '.join(arm.joint_names)}")
    if first == second:
        raise ParameterError("joints", f"'{first}' given twice, two different joints expected")
    if others not in get_args(Others):
        raise ParameterError("others", f"'{others}' given, held or largest expected")
    if resolution < 2:
        raise ParameterError("resolution", f"{resolution} given, at least 2 expected")
    i, j = arm.joint_names.index(first), arm.joint_names.index(second)
    if others == "largest":
        points = sample_box(domain, samples, seed)
        norms = figures_at(NORM[condition], arm.tree, points, values, armature)
        return _binned(domain, (first, second), (i, j), points, norms, resolution)
    x, y = (np.linspace(domain.lower[k], domain.upper[k], resolution) for k in (i, j))
    points = np.tile(domain.centre if q is None else np.asarray(q, dtype=np.float64), (resolution**2, 1))
    points[:, i], points[:, j] = (grid.ravel() for grid in np.meshgrid(x, y))
    norms = figures_at(NORM[condition], arm.tree, points, values, armature).reshape(resolution, resolution)
    return Heatmap((first, second), x, y, norms, "held")


def pairs(arm: Arm, box: BoxLike = None) -> list[tuple[str, str]]:
    """Pairs of joints whose norm is worth a map: those that M depends on and that the box leaves free."""
    free = resolve_box(arm, box).free
    return list(combinations([name for name, is_free in zip(arm.joint_names, free, strict=True) if is_free], 2))


def _binned(
    box: Box, joints: tuple[str, str], index: tuple[int, int], points: Array, norms: Array, resolution: int
) -> Heatmap:
    edges = [np.linspace(box.lower[k], box.upper[k], resolution + 1) for k in index]
    cell = [
        np.clip(np.searchsorted(e, points[:, k], "right") - 1, 0, resolution - 1)
        for e, k in zip(edges, index, strict=True)
    ]
    largest = np.full((resolution, resolution), -np.inf)
    np.maximum.at(largest, (cell[1], cell[0]), norms)
    largest[np.isinf(largest)] = np.nan
    x, y = (0.5 * (e[1:] + e[:-1]) for e in edges)
    return Heatmap(joints, x, y, largest, "largest")
