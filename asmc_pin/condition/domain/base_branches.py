"""Branches of an arm that hang on the base one by one: M(q) is block diagonal, and each block is a problem of its own.

The inertia of a branch does not depend on the joints of another. M̄ is diagonal, so N M + M N, M − M̄ and every other
matrix of a statement falls into the same blocks: it is positive definite exactly when each block is.
"""

from __future__ import annotations

import numpy as np

from asmc_pin._typing import IntArray
from asmc_pin.rigid_body.coupling import Coupling
from asmc_pin.rigid_body.tree import Tree


def branches(tree: Tree) -> list[IntArray]:
    """The coordinates of each branch, in the order of their first ones.

    Branches that have a coordinate in common, because a joint of one mimics a joint of another, are one.

    Args:
        tree: The arm.

    Returns:
        Indices of coordinates, each ascending; one array for an arm with one joint on the base.
    """
    coordinate = tree.coupling.coordinate
    group = np.arange(tree.nv)
    for joint, before in enumerate(tree.parent):
        if before >= 0:
            one, other = group[coordinate[joint]], group[coordinate[before]]
            group[group == max(one, other)] = min(one, other)
    return [np.flatnonzero(group == first) for first in np.unique(group)]


def branch_of(tree: Tree, coordinates: IntArray) -> Tree:
    """The tree of one branch alone, with what mimics its joints."""
    if len(coordinates) == tree.nv:
        return tree
    coupling = tree.coupling
    joints = np.flatnonzero(np.isin(coupling.coordinate, coordinates))
    place = np.full(tree.joints + 1, -1)  # the last entry is that of the base, −1
    place[joints] = np.arange(len(joints))
    return Tree(
        parent=place[tree.parent[joints]],
        rotation=tree.rotation[joints],
        translation=tree.translation[joints],
        axis=tree.axis[joints],
        prismatic=tree.prismatic[joints],
        mass=tree.mass[joints],
        com=tree.com[joints],
        inertia=tree.inertia[joints],
        armature=tree.armature[coordinates],
        gravity=tree.gravity,
        coupling=Coupling(
            np.searchsorted(coordinates, coupling.coordinate[joints]),
            coupling.ratio[joints],
            coupling.offset[joints],
            place[coupling.leader[coordinates]],
        ),
    )
