"""A statement cut into what is proven one by one: branches that hang on the base, and pieces of a box.

Where joints mimic others, the free tree stands in for the arm (docs/certificate.md, Joints that mimic others): with
q̇_joints = S q̇, a form of all joints that is positive for every velocity of theirs, with parts of m̄ that come to m̄ on
what S allows, is positive for the arm. Each piece of the coordinates' box has such parts of its own; the box of the
joints is the image of the piece, so that no configuration of the arm is outside.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb, ctx

from asmc_pin._typing import Array, IntArray
from asmc_pin.condition.checker.boxes.bisection import Broken, Bytes, by_branch, cells, one_bisection
from asmc_pin.condition.checker.boxes.quadratic_form import Borne, Form, form_of, form_with
from asmc_pin.condition.checker.reading.coupled_joints import Following
from asmc_pin.condition.checker.reading.header_parts import Header, Malformed, WrittenCase, WrittenStatement
from asmc_pin.condition.checker.reading.link_chain import Chain

_ROUNDING = 1e-14
"""Share of its ends by which the image of a box is wider, for the products and sums that it is made of."""

_LESS = 1e-12
"""Share of what is borne evenly that is left away, for its rounding."""


@dataclass(frozen=True, eq=False)
class StatementPart:
    """One branch, or one piece of it.

    Attributes:
        joints: Its joints, among all that move.
        form: The statement of them alone, over their box.
        record: The bisection of that box, in which they are numbered from 0.
        leaders: Of an arm with joints that follow others: the place among `joints` of each coordinate's own joint.
        coordinates: These coordinates.
    """

    joints: IntArray
    form: Form
    record: Bytes
    leaders: IntArray
    coordinates: IntArray

    def among(self, centre: Array, half: Array, case: WrittenCase) -> tuple[Array, Array]:
        """A cell as one of all coordinates: the others stand in the middle of their ranges."""
        lower, upper = np.array(case.lower), np.array(case.upper)
        middle, still = 0.5 * (lower + upper), np.zeros_like(lower)
        middle[self.coordinates], still[self.coordinates] = centre[self.leaders], half[self.leaders]
        return np.clip(middle, lower, upper), still


def whole_form(told: Header, statement: WrittenStatement, chain: Chain) -> Form:
    """The statement of all joints together over the whole box; where some follow, only good for what S allows."""
    case = told.cases[statement.case]
    lower, upper, mbar = np.array(case.lower), np.array(case.upper), np.array(told.mbar)
    if not chain.follows:
        return form_of(chain, mbar, statement, lower, upper)
    own = _at_leaders(chain, mbar)
    low, high = image(chain, lower, upper)
    return form_with(chain, _borne(chain, mbar, statement, own, own), statement, low, high)


def parts_of(
    told: Header, statement: WrittenStatement, record: Bytes, chain: Chain, follow: Following
) -> Iterator[StatementPart]:
    """The parts of a statement, which all together are more than it says.

    Args:
        told: The header.
        statement: The statement.
        record: Its bisections.
        chain: Its case's arm.
        follow: How joints follow coordinates, in balls.

    Raises:
        Broken: The record is no such bisections.
        Malformed: Joints bear another part of m̄ than they have to.
    """
    if chain.follows:
        yield from _of_followers(told, statement, record, chain, follow)
        return
    whole = whole_form(told, statement, chain)
    for joints, part in by_branch(record, chain.parent):
        here = np.arange(joints.size)
        yield StatementPart(joints, whole.branch(joints), part, here, joints)


def _of_followers(
    told: Header, statement: WrittenStatement, record: Bytes, chain: Chain, follow: Following
) -> Iterator[StatementPart]:
    case = told.cases[statement.case]
    lower, upper, mbar = np.array(case.lower), np.array(case.upper), np.array(told.mbar)
    at, used = 0, 0
    for coordinates in coupled_branches(chain):
        joints = np.flatnonzero(np.isin(chain.coordinate, coordinates))
        pieces, at = one_bisection(record, at, coordinates)
        for part in cells(pieces, coordinates.size):
            for centre, half in zip(*part.boxes(lower[coordinates], upper[coordinates]), strict=True):
                own, at = one_bisection(record, at, joints)
                if used == len(statement.weights):
                    raise Malformed("a statement has fewer rows of weights than pieces of its box")
                weights = _checked(told, statement, chain, follow, joints, statement.weights[used])
                used += 1
                low, high = lower.copy(), upper.copy()
                low[coordinates], high[coordinates] = centre - half, centre + half
                most, least = np.zeros(chain.parent.size), _evenly(chain, mbar)
                if statement.kind == "bounded":
                    least[joints] = weights
                else:
                    most[joints] = weights
                form = form_with(
                    chain, _borne(chain, mbar, statement, most, least), statement, *image(chain, low, high)
                ).branch(joints)
                leaders = np.searchsorted(joints, chain.leader[coordinates])
                yield StatementPart(joints, form, own, leaders, coordinates)
    if at != record.size:
        raise Broken(f"the record goes on after its last box, at byte {at}")
    if used != len(statement.weights):
        raise Malformed("a statement has more rows of weights than pieces of its box")


def coupled_branches(chain: Chain) -> list[IntArray]:
    """Coordinates whose joints hang together on the base, or follow each other, in the order of their first ones."""
    group = np.arange(chain.leader.size)
    for joint, before in enumerate(chain.parent.tolist()):
        if before >= 0:
            one, other = group[chain.coordinate[joint]], group[chain.coordinate[before]]
            group[group == max(one, other)] = min(one, other)
    return [np.flatnonzero(group == first) for first in np.unique(group)]


def image(chain: Chain, lower: Array, upper: Array) -> tuple[Array, Array]:
    """A box of the joints that holds all values that they have over a box of the coordinates."""
    ends = np.sort(np.stack([chain.joints(lower), chain.joints(upper)]), axis=0)
    far = np.maximum(np.abs(lower), np.abs(upper))[chain.coordinate]
    wider = _ROUNDING * (np.abs(chain.ratio) * far + np.abs(chain.offset))
    return ends[0] - wider, ends[1] + wider


def _borne(chain: Chain, mbar: Array, statement: WrittenStatement, most: Array, least: Array) -> Borne:
    armature, slack = (_at_leaders(chain, np.array(own)) for own in (statement.armature, statement.slack))
    return Borne(mbar[chain.coordinate], armature, slack, most, least)


def _at_leaders(chain: Chain, values: Array) -> Array:
    out = np.zeros(chain.parent.size)
    out[chain.leader] = values
    return out


def _evenly(chain: Chain, mbar: Array) -> Array:
    """Parts of m̄ that on what S allows come to no more than m̄."""
    count = np.bincount(chain.coordinate, minlength=chain.leader.size)[chain.coordinate]
    return np.asarray((1.0 - _LESS) * mbar[chain.coordinate] / (count * chain.ratio**2))


def _checked(
    told: Header, statement: WrittenStatement, chain: Chain, follow: Following, joints: IntArray, row: Sequence[float]
) -> Array:
    """Weights that on what S allows come to m̄, to more where the form falls with them, to less where it grows.

    Raises:
        Malformed: They do not.
    """
    if len(row) != joints.size:
        raise Malformed("a row of weights has not one number for each joint of its branch")
    with ctx.workprec(256):
        for c in np.unique(chain.coordinate[joints]).tolist():
            # Zeros are exact in balls, and the ratios of decimals nearly so: equality is not asked for.
            borne = sum(
                (
                    follow.ratio[joint] ** 2 * arb(float(weight))
                    for joint, weight in zip(joints.tolist(), row, strict=True)
                    if chain.coordinate[joint] == c
                ),
                arb(0),
            )
            enough = borne <= arb(told.mbar[c]) if statement.kind == "bounded" else borne >= arb(told.mbar[c])
            if not enough:
                raise Malformed(f"the joints that follow '{told.joints[c]}' do not bear its m̄")
    return np.array(row)
