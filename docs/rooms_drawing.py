"""The rooms and their imports as a picture, docs/images/rooms.svg: each row's order by igraph, its places by scipy."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from html import escape
from itertools import pairwise

import igraph
import numpy as np
from import_graph import PACKAGE, circles, layers, reduced, room_graph
from scipy.optimize import linprog

_BOX = (112, 30)
"""Of a room, pixels."""

_BESIDE = 14
"""From a room, or from an arrow that passes, to what stands beside it, pixels."""

_ROW, _EDGE = 72, 20
"""From row to row, and about all of it, pixels."""

Point = tuple[int, int]

_STYLE = (
    ".paper{fill:#fff}.box{fill:#f4f6f8;stroke:#566173}.arrow{fill:none;stroke:#7b8898;stroke-width:1.3}"
    "text{font:14px system-ui,sans-serif;text-anchor:middle;fill:#1b2230}"
)


def rooms_svg() -> str:
    """The picture: who imports stands above what it imports. It has its own white ground, for a page that is dark."""
    graph = room_graph()
    assert not circles(graph), circles(graph)
    places, ways = placed(graph)
    reached = [*((x + _BOX[0] // 2, y) for x, y in places.values()), *(point for way in ways.values() for point in way)]
    width = max(x for x, _ in reached) + _EDGE
    height = max(y for _, y in places.values()) + _BOX[1] // 2 + _EDGE
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}">',
        f"<style>{_STYLE}</style>",
        '<defs><marker id="head" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
        '<path d="M0 0L8 4L0 8z" fill="#7b8898"/></marker></defs>',
        f'<rect class="paper" width="{width}" height="{height}" rx="8"/>',
        *(_arrow(pair, way) for pair, way in sorted(ways.items())),
        *(_box(room, at) for room, at in sorted(places.items())),
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def placed(graph: Mapping[str, Collection[str]]) -> tuple[dict[str, Point], dict[tuple[str, str], list[Point]]]:
    """Where the middle of each room's box is, and through which points each arrow goes, in pixels.

    Args:
        graph: Room -> rooms that it imports, without a circle.
    """
    depth = {room: row for row, members in enumerate(reversed(layers(graph))) for room in members}
    rooms = sorted(depth)
    arrows = [(room, other) for room, others in sorted(reduced(graph).items()) for other in sorted(others)]
    # An arrow that passes rows is a chain of points, one in each, so that the rooms there leave it room.
    row_of = [depth[room] for room in rooms]
    chains = []
    for room, other in arrows:
        passed = range(depth[room] + 1, depth[other])
        chains.append([rooms.index(room), *range(len(row_of), len(row_of) + len(passed)), rooms.index(other)])
        row_of += passed
    steps = [pair for chain in chains for pair in pairwise(chain)]
    drawn = igraph.Graph(steps, n=len(row_of), directed=True).layout_sugiyama(layers=row_of, maxiter=1000)
    order: list[list[int]] = [[] for _ in range(1 + max(row_of))]
    for node in sorted(range(len(row_of)), key=lambda node: drawn[node][0]):
        order[row_of[node]].append(node)
    across = _across(order, steps, len(rooms))
    points = [(_EDGE + x, _EDGE + _BOX[1] // 2 + _ROW * row) for x, row in zip(across, row_of, strict=True)]
    half = _BOX[1] // 2
    ways = {}
    for pair, chain in zip(arrows, chains, strict=True):
        (x, y), *between, (to_x, to_y) = (points[node] for node in chain)
        # Along the boxes of a row it goes straight down, and bends between rows only.
        through = [(at_x, at_y + edge) for at_x, at_y in between for edge in (-half, half)]
        ways[pair] = [(x, y + half), *through, (to_x, to_y - half)]
    return dict(zip(rooms, points, strict=False)), ways


def _across(order: Sequence[Sequence[int]], steps: Sequence[tuple[int, int]], rooms: int) -> list[int]:
    """Places from left to right that keep each row's order and make the arrows as upright as may be.

    Args:
        order: The nodes of each row, from the left.
        steps: Pairs of nodes of neighbouring rows that an arrow joins.
        rooms: So many of the nodes are rooms, with boxes; the others are points of an arrow.
    """
    count = 1 + max(node for row in order for node in row)
    half = [(_BOX[0] / 2 if node < rooms else 0) + _BESIDE / 2 for node in range(count)]
    rules, least = [], []

    def rule(coefficients: Mapping[int, float], at_most: float) -> None:
        line = np.zeros(count + len(steps))
        line[list(coefficients)] = list(coefficients.values())
        rules.append(line)
        least.append(at_most)

    for left, right in (pair for row in order for pair in pairwise(row)):
        rule({left: 1, right: -1}, -half[left] - half[right])
    for k, (node, other) in enumerate(steps):
        rule({node: 1, other: -1, count + k: -1}, 0)
        rule({node: -1, other: 1, count + k: -1}, 0)
    # A bend amid an arrow is worse than a slant at its ends; what costs nothing is drawn to the left.
    costs = [1e-4] * count + [1 + 2 * (node >= rooms) + 2 * (other >= rooms) for node, other in steps]
    from_left = [(half[node] - _BESIDE / 2, None) for node in range(count)] + [(0, None)] * len(steps)
    solved = linprog(costs, A_ub=np.array(rules), b_ub=least, bounds=from_left, method="highs")
    return [round(x) for x in solved.x[:count]]


def _arrow(pair: tuple[str, str], way: Sequence[Point]) -> str:
    """A curve through the points, upright at each of them."""
    drawn = f"M{way[0][0]} {way[0][1]}"
    for (x, y), (to_x, to_y) in pairwise(way):
        bend = (y + to_y) // 2
        drawn += f"V{to_y}" if x == to_x else f"C{x} {bend} {to_x} {bend} {to_x} {to_y}"
    said = escape(" imports ".join(pair))
    return f'<path class="arrow" marker-end="url(#head)" d="{drawn}"><title>{said}</title></path>'


def _box(room: str, at: Point) -> str:
    label = escape(room if (PACKAGE / room).is_dir() else f"{room}.py")
    x, y = at[0] - _BOX[0] // 2, at[1] - _BOX[1] // 2
    return (
        f'<rect class="box" x="{x}" y="{y}" width="{_BOX[0]}" height="{_BOX[1]}" rx="6"/>'
        f'<text x="{at[0]}" y="{at[1] + 5}">{label}</text>'
    )
