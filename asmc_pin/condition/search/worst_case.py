"""The worst configuration, searched: low-discrepancy samples, then local maximisation with exact gradients.

A search gives a value that some configuration really has. It refutes; it never proves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from asmc_pin._typing import Array, BoolArray, IntArray
from asmc_pin.condition.domain.base_branches import branches
from asmc_pin.condition.norm import compiled_norms
from asmc_pin.condition.search import compiled_climb
from asmc_pin.condition.search.samples import Domain, figures_at, sample_box

if TYPE_CHECKING:
    pass

GUIDES = {
    compiled_norms.LEMMA1: (compiled_norms.LEMMA1_SCALE, compiled_norms.WEIGHTED_SCALE, compiled_norms.BANDWIDTH),
    compiled_norms.WEIGHTED: (compiled_norms.WEIGHTED_SCALE, compiled_norms.BANDWIDTH),
    compiled_norms.LEMMA1_SCALE: (compiled_norms.LEMMA1, compiled_norms.WEIGHTED_SCALE),
    compiled_norms.WEIGHTED_SCALE: (compiled_norms.LEMMA1,),
    compiled_norms.BANDWIDTH: (compiled_norms.LEMMA1,),
}
"""Figures that are climbed first, and then the one that is asked for from where they end.

A norm is the larger of a branch where M̄ is too small and one where it is too large. The first is often broad and flat
and hides the second, narrow and higher, from the samples and from every climb that starts at the best of them.
"""

SAMPLES = 2**15
STARTS = 64


@dataclass(frozen=True, eq=False)
class Found:
    """What a search found.

    Attributes:
        value: The largest value of the figure.
        q: Where, shape (nv,).
        armature: With which armature, shape (nv,), kg·m².
        samples: The figure at the samples, shape (samples,).
        configurations: How many configurations were evaluated, gradients included.
        maxima: The figure at the end of every climb, shape (climbs,).
        maxima_q: Where, shape (climbs, nv).
        maxima_armature: With which armature, shape (climbs, nv).
    """

    value: float
    q: Array
    armature: Array
    samples: Array
    configurations: int
    maxima: Array
    maxima_q: Array
    maxima_armature: Array


def maximise(
    kind: int,
    domain: Domain,
    mbar: Array,
    *,
    samples: int = SAMPLES,
    starts: int = STARTS,
    seed: int = 0,
    threads: int = 1,
    also: tuple[Array, Array] | None = None,
) -> Found:
    """Largest value of a figure over a domain, as far as a search can tell.

    Samples the box, each with the armature at a random end of its range (the conditions are convex in the armature, so
    an end is worst), then climbs, angles and armature together, from the best samples that are apart from each other,
    from where climbs of other figures end (see `GUIDES`), and from some that were not chosen at all. Each branch on the
    base is a block of M(q) and is searched alone: a figure of the whole is the largest of its blocks'.

    Args:
        kind: `compiled_norms.LEMMA1` and its fellows; all are figures of which more is worse.
        domain: What is varied.
        mbar: Diagonal of M̄, shape (nv,).
        samples: Number of samples.
        starts: Number of local climbs.
        seed: Of the samples.
        threads: Worker threads of the sampling.
        also: Further starts: configurations (count, nv) and their armatures (count, nv).

    Returns:
        What was found.
    """
    box, size = domain.box, domain.joints.size
    q = sample_box(box, samples, seed)
    lower, upper = domain.armature_lower, domain.armature_upper
    if np.any(upper > lower):
        ends = np.random.default_rng(seed).random((samples, size)) < 0.5
        armature = np.where(ends, lower, upper)
    else:
        armature = lower[None, :]
    more = also or (np.empty((0, size)), np.empty((0, size)))
    parts = domain.by_branch()
    if len(parts) == 1:
        return _of_branch(kind, domain, mbar, q, armature, starts, threads, more)
    found = []
    for part, mine in zip(parts, branches(domain.tree), strict=True):
        given = more[0][:, mine], more[1][:, mine]
        found.append(_of_branch(kind, part, mbar[mine], q[:, mine], armature[:, mine], starts, threads, given))
    return _together(found, branches(domain.tree))


def _of_branch(
    kind: int,
    domain: Domain,
    mbar: Array,
    q: Array,
    armature: Array,
    starts: int,
    threads: int,
    also: tuple[Array, Array],
) -> Found:
    """The largest value over a domain whose joints all hang together."""
    box, lower, upper = domain.box, domain.armature_lower, domain.armature_upper
    ranged = np.any(upper > lower)
    values = figures_at(kind, domain.tree, q, mbar, armature, threads)
    configurations = len(q)
    first = int(np.argmax(values))
    best = (float(values[first]), q[first], armature[first % len(armature)])
    climbed, where, carried = values[first : first + 1], q[first : first + 1], best[2][None]
    if starts > 0 and (box.free.any() or ranged):
        begin, begin_armature, calls = _starts(kind, domain, q, armature, mbar, values, starts)
        begin, begin_armature = np.concatenate((begin, also[0])), np.concatenate((begin_armature, also[1]))
        climbed, where, carried, more = _climb(kind, domain, mbar, begin, begin_armature)
        configurations += calls + more
        top = int(np.argmax(climbed))
        if climbed[top] > best[0]:
            best = (float(climbed[top]), where[top], carried[top])
        if ranged:
            # A climb may end on a plateau; the end of the range next to it is no better.
            end = np.where(best[2] - lower > upper - best[2], upper, lower)
            at_end = figures_at(kind, domain.tree, best[1][None], mbar, end)[0]
            if at_end >= best[0] * (1.0 - 1e-12) - 1e-15:
                best = (float(at_end), best[1], end)
    return Found(best[0], box.wrap(best[1]), best[2], values, configurations, climbed, box.wrap(where), carried)


def _together(found: Sequence[Found], parts: Sequence[IntArray]) -> Found:
    """What was found on each branch, as configurations of the whole arm: every figure of it is the largest of theirs.

    The highest climb of one branch goes with the highest of the others, the second with the second; a branch with fewer
    climbs than another stays at its own highest.
    """
    count = max(item.maxima.size for item in found)
    size = sum(part.size for part in parts)
    q, armature = np.empty(size), np.empty(size)
    maxima, maxima_q, maxima_armature = np.full(count, -np.inf), np.empty((count, size)), np.empty((count, size))
    for item, mine in zip(found, parts, strict=True):
        q[mine], armature[mine] = item.q, item.armature
        order = np.argsort(-item.maxima, kind="stable")
        order = np.concatenate((order, np.repeat(order[:1], count - order.size)))
        maxima = np.maximum(maxima, item.maxima[order])
        maxima_q[:, mine], maxima_armature[:, mine] = item.maxima_q[order], item.maxima_armature[order]
    return Found(
        max(item.value for item in found),
        q,
        armature,
        np.max([item.samples for item in found], axis=0),
        sum(item.configurations for item in found),
        maxima,
        maxima_q,
        maxima_armature,
    )


def _starts(
    kind: int, domain: Domain, q: Array, armature: Array, mbar: Array, values: Array, count: int
) -> tuple[Array, Array, int]:
    """Where to climb from: half of the best samples, a quarter unchosen, and where climbs of the guides end."""
    free, periodic = domain.box.free, domain.box.periodic[domain.box.free]
    chosen = _apart(q[:, free], values, (count + 1) // 2, periodic)
    index = np.concatenate((chosen, np.arange(min((count + 1) // 4, len(q)))))
    starts, carried, evaluations = [q[index]], [armature[index % len(armature)]], 0
    few = min(len(q), 8192)
    for guide in GUIDES[kind]:
        other = figures_at(guide, domain.tree, q[:few], mbar, armature[:few])
        index = _apart(q[:few, free], other, (count + 3) // 4, periodic)
        _, where, with_armature, calls = _climb(guide, domain, mbar, q[index], armature[index % len(armature)])
        starts.append(where)
        carried.append(with_armature)
        evaluations += few + calls
    return np.concatenate(starts), np.concatenate(carried), evaluations


def _apart(q: Array, values: Array, count: int, periodic: BoolArray) -> IntArray:
    """Indices of the best samples, none within 0.4 rad (by the largest joint difference) of a better one."""
    order = np.argsort(-values, kind="stable")[: 200 * count]
    rest, points = order, q[order]
    chosen: list[int] = []
    while rest.size and len(chosen) < count:
        chosen.append(int(rest[0]))
        difference = np.abs(points - points[0])
        difference = np.where(periodic, np.minimum(difference, 2.0 * np.pi - difference), difference)
        # Without a free joint all samples are one.
        far = difference.max(axis=1, initial=0.0) > 0.4
        rest, points = rest[far], points[far]
    return np.array(chosen, dtype=np.int64)


def _climb(kind: int, domain: Domain, mbar: Array, q: Array, armature: Array) -> tuple[Array, Array, Array, int]:
    """Local maxima from starts (count, nv): values, angles, armatures, evaluations."""
    box = domain.box
    lower = np.where(box.periodic, -np.inf, box.lower)
    upper = np.where(box.periodic, np.inf, box.upper)
    lower, upper = np.where(box.free, lower, box.centre), np.where(box.free, upper, box.centre)
    width = domain.armature_upper - domain.armature_lower
    share = (armature - domain.armature_lower) / np.where(width > 0.0, width, 1.0)
    z = np.concatenate((q, share), axis=1)
    values = np.empty(len(z))
    bounds = np.concatenate((lower, 0.0 * width)), np.concatenate((upper, 1.0 * (width > 0.0)))
    least = np.array(domain.armature_lower)
    evaluations = compiled_climb.climb(kind, domain.links, np.array(mbar), z, *bounds, least, width, values)
    found = z[:, : mbar.size]
    return values, found, domain.armature_lower + width * z[:, mbar.size :], int(evaluations)
