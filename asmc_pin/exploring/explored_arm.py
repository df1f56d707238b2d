"""What the explorer's page computes with: the arm's numbers as Python has them, M̄, the worst configuration, boxes."""

from __future__ import annotations

import base64
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.stats import qmc

from asmc_pin._typing import Array
from asmc_pin.condition.certificate.walk import Record
from asmc_pin.condition.domain.joint_box import Box
from asmc_pin.viewer import PlayedMotion, describe, draw
from asmc_pin.viewer.stage import Stage, stage

if TYPE_CHECKING:
    from asmc_pin.arms import Arm
    from asmc_pin.condition import ConditionReport
    from asmc_pin.rigid_body.tree import Tree

_COLOUR = "#0072B2"


@dataclass(frozen=True)
class Gains:
    """Gains of the sampled loop that the page begins with: K_s = ks I and β, 1/s, and the period L, s."""

    ks: float
    beta: float
    period: float


@dataclass(frozen=True, eq=False)
class KnownBoxes:
    """Joint boxes of which something is known.

    Attributes:
        records: See `BoxPartition.records`; of all joints together, or one for each branch on the base.
        scale: What is proven is proven of M̄ times this, and so of every smaller multiple.
        note: What they are and where they come from, a sentence.
        holds: Whether they prove the condition for M̄ itself over the whole joint box.
    """

    records: tuple[Record, ...]
    scale: float
    note: str
    holds: bool


def described(
    arm: Arm, report: ConditionReport, box: Box, gains: Gains, boxes: KnownBoxes | None, *, live: bool
) -> tuple[dict[str, Any], tuple[str, ...]]:
    """All of it, ready for JSON, in which numbers survive to the last digit; and what to know of the picture.

    Args:
        arm: The arm.
        report: What a search of the box found for M̄.
        box: The joint box.
        gains: Where the page begins.
        boxes: Boxes to show; None for none.
        live: Whether the page may ask its server about collisions.
    """
    start = np.clip(0.0, box.lower, box.upper)
    drawn = draw(arm)
    sweep = _sweep(start, box)
    motion = PlayedMotion(arm.name, _COLOUR, sweep)
    scene = describe(drawn, arm.joint_names, np.arange(len(sweep)) / 60.0, [motion], None)
    _stand(scene["stage"], stage(drawn, [start[None]]))
    data = {
        "links": links_json(arm.tree),
        "joints": [
            {
                "name": name,
                "prismatic": kind == "prismatic",
                "lower": float(lower),
                "upper": float(upper),
                "idle": bool(idle),
            }
            for name, kind, lower, upper, idle in zip(
                arm.joint_names, arm.joint_kinds, box.lower, box.upper, box.idle, strict=True
            )
        ],
        "condition": report.condition,
        "mbar": report.mbar.tolist(),
        "start": start.tolist(),
        "worst": {"q": report.worst_q.tolist(), "norm": report.lower},
        "gains": {"ks": gains.ks, "beta": gains.beta, "period": gains.period},
        "plane": _plane(box),
        "cells": None if boxes is None else {"records": list(map(_packed, boxes.records)), "scale": boxes.scale},
        "cellsNote": "" if boxes is None else boxes.note,
        "proven": boxes is not None and boxes.holds,
        "live": live,
        "scene": scene,
    }
    return data, drawn.notes


def links_json(tree: Tree) -> dict[str, Any]:
    """The numbers that M(q) is made of, joint by joint, those that mimic others included; matrices row by row."""
    coupling = tree.coupling
    plain = {"parent": tree.parent, "prismatic": tree.prismatic, "mass": tree.mass, "armature": tree.armature}
    rows = {name: getattr(tree, name).ravel() for name in ("rotation", "translation", "axis", "com", "inertia")}
    follow = {name: getattr(coupling, name) for name in ("coordinate", "ratio", "offset")}
    return {name: values.tolist() for name, values in (plain | rows | follow).items()}


def _sweep(start: Array, box: Box) -> Array:
    """Configurations that the camera must see, the start first: each joint alone over its range, and some at random."""
    frames = [start[None]]
    for k in range(start.size):
        alone = np.tile(start, (5, 1))
        alone[:, k] = np.linspace(box.lower[k], box.upper[k], 5)
        frames.append(alone)
    sobol = qmc.Sobol(start.size, seed=0).random(32)
    frames.append(box.lower + sobol * (box.upper - box.lower))
    return np.concatenate(frames)


def _stand(shown: dict[str, Any], at_start: Stage) -> None:
    """The ground where the arm stands at first: one as low as the lowest that it could reach lies far below it."""
    shown["ground"], shown["pedestal"] = at_start.ground, at_start.pedestal
    shown["outline"] = [point for point in shown["outline"] if point[2] >= at_start.ground]
    shown["outline"] += [point.tolist() for point in at_start.outline]


def _plane(box: Box) -> list[int]:
    """The two joints that the map begins with: the first two that M depends on, where there are two."""
    order = np.argsort(~box.free, kind="stable")
    return [int(k) for k in order[:2]]


def _packed(record: Record) -> str:
    return base64.b64encode(record.tobytes()).decode()
