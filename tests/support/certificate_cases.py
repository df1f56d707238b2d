"""Random arms, boxes and M̄ for the tests of proofs, and how far single boxes can be proven on them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from asmc_pin import load_arm
from asmc_pin._typing import Array
from asmc_pin.condition import lemma1_norm, weighted_norm
from asmc_pin.condition.certificate import CertificateResult, certify
from asmc_pin.condition.certificate.compiled.bisection_tree import DONE, explore
from asmc_pin.condition.certificate.statement import Kind, Statement
from asmc_pin.condition.certificate.statement_forms import problem_of
from asmc_pin.rigid_body.coupling import uncoupled
from asmc_pin.rigid_body.mass_matrix import mass_matrices
from asmc_pin.rigid_body.tree import Tree

UR5_WEIGHTED = (0.2978, 0.514, 0.1109, 0.0546, 0.0313, 0.0022)
"""Near the best M̄ of the bare UR5 under the weighted condition; a violation at 1.033 times it is known."""


def blocks(numbers: range) -> list[Any]:
    """Numbers of blocks of cases for `make soundness`, every third of which `make test-all` runs too."""
    return [pytest.param(k, marks=[pytest.mark.long] if k % 3 == 0 else []) for k in numbers]


@cache
def ur5_certificate() -> CertificateResult:
    """A proof of the weighted condition on the UR5, made once for all that look at it."""
    return certify(load_arm("ur5"), UR5_WEIGHTED, condition="weighted", gap=0.01, budget=60.0)


def random_tree(rng: np.random.Generator, joints: int) -> Tree:
    """An arm with any axes (half of them along coordinates), light and heavy links, branches and sliding joints."""
    n = joints
    parent = np.array(
        [-1] + [i - 1 if rng.random() < 0.8 else rng.integers(-1, i) for i in range(1, n)], dtype=np.int64
    )
    rotation = Rotation.random(n, rng=rng).as_matrix()
    axis = rng.normal(size=(n, 3)) if rng.random() < 0.5 else np.eye(3)[rng.integers(0, 3, n)]
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    mass = 10.0 ** rng.uniform(-1.5, 1.0, n)
    inertia = np.empty((n, 3, 3))
    for i in range(n):
        cloud = rng.normal(size=(5, 3)) * 10.0 ** rng.uniform(-2.5, -0.5, 3)
        cloud -= cloud.mean(axis=0)
        inertia[i] = mass[i] / 5.0 * (np.sum(cloud**2) * np.eye(3) - cloud.T @ cloud) + 1e-6 * np.eye(3)
    slides = rng.random(n) < (0.15 if rng.random() < 0.5 else 0.0)
    armature = 10.0 ** rng.uniform(-3.0, -0.5, n) * (rng.random() < 0.6)
    translation, com = 0.3 * rng.normal(size=(n, 3)), 0.15 * rng.normal(size=(n, 3))
    return Tree(parent, rotation, translation, axis, slides, mass, com, inertia, armature, np.zeros(3), uncoupled(n))


def random_box(rng: np.random.Generator, tree: Tree) -> tuple[Array, Array]:
    """Centre and half width, from hundredths of a radian to a whole turn, some joints held."""
    n = tree.nv
    half = np.minimum(10.0 ** rng.uniform(-2.5, 0.55, n) * (rng.random(n) < 0.9), np.pi)
    if rng.random() < 0.3:
        half[:] = half.max()
    return rng.uniform(-3.0, 3.0, n), np.where(tree.prismatic, np.minimum(half, 0.5), half)


def climb(tree: Tree, lower: Array, upper: Array, figure: Callable[[Array], Array], seed: int) -> float:
    """Largest value of a figure of M(q) over a box that samples and a pattern search from the best of them find."""
    rng = np.random.default_rng(seed)
    n = tree.nv
    ends = rng.choice([0.0, 0.5, 1.0], size=(400, n))
    q = np.concatenate((rng.uniform(lower, upper, (1500, n)), lower + ends * (upper - lower)))
    value = figure(mass_matrices(tree, q))
    best = np.argsort(-value)[:16]
    q, value, step = q[best], value[best], np.full(16, 0.3)
    while step.max() > 1e-6:
        direction = rng.normal(size=(16, 3 * n, n))
        direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
        direction[:, :n] = np.eye(n) * rng.choice([-1.0, 1.0], size=(16, 1, 1))
        trial = np.clip(q[:, None] + step[:, None, None] * direction, lower, upper)
        found = figure(mass_matrices(tree, trial.reshape(-1, n))).reshape(16, -1)
        top = found.argmax(axis=1)
        better = found[np.arange(16), top] > value
        q[better] = trial[np.arange(16), top][better]
        value[better] = found[np.arange(16), top][better]
        step = np.where(better, 1.3 * step, 0.6 * step)
    return float(value.max())


@dataclass(frozen=True)
class Question:
    """A family of statements about one box, the stronger the larger x, of which x > worst are false.

    Attributes:
        tree: The arm.
        lower: Box.
        upper: Box.
        mbar: M̄.
        kind: See `problem`.
        worst: The x at which a configuration of the box contradicts.
    """

    tree: Tree
    lower: Array
    upper: Array
    mbar: Array
    kind: Kind
    worst: float

    def statement(self, x: float) -> Statement:
        """The statement at x: a scale, or 1 − a level."""
        none = np.zeros(self.tree.nv)
        if self.kind in ("weighted", "lemma1"):
            return Statement(self.kind, x, 1.0, 0, self.tree.armature, none)
        return Statement(self.kind, 1.0, 1.0 - x, 0, self.tree.armature, none)


def question(seed: int, kind: Kind, largest: int = 6, point: bool = False) -> Question | None:
    """A random question of a kind, about a box or a single configuration; None where M̄ is such that no x is true."""
    rng = np.random.default_rng(seed)
    tree = random_tree(rng, int(rng.integers(1, largest + 1)))
    centre, half = random_box(rng, tree)
    half = 0.0 * half if point else half
    lower, upper = centre - half, centre + half
    mass = mass_matrices(tree, rng.uniform(lower, upper, (64, tree.nv)))
    mbar = np.diagonal(mass, axis1=1, axis2=2).min(axis=0) * rng.uniform(0.2, 1.0, tree.nv)
    if kind in ("lemma1", "level") and rng.random() < 0.7:
        # One M̄ for all joints always has a scale that Lemma 1 allows.
        mbar[:] = 0.5 * np.linalg.eigvalsh(mass)[:, 0].min() * rng.uniform(0.8, 1.2, tree.nv)
    root, inverse = 1.0 / np.sqrt(mbar), 1.0 / mbar
    if kind == "weighted":
        worst = -climb(tree, lower, upper, lambda M: -2.0 * np.linalg.eigvalsh(M * root[:, None] * root)[:, 0], seed)
    elif kind == "bounded":
        top = climb(tree, lower, upper, lambda M: np.linalg.eigvalsh(M * root[:, None] * root)[:, -1], seed)
        worst = 1.0 / top
    else:

        def scale(M: Array) -> Array:
            return -np.linalg.eigvalsh(M * (inverse[:, None] + inverse))[:, 0]

        worst = -climb(tree, lower, upper, scale, seed)
        if kind == "level" and worst > 1e-3:
            mbar = mbar * worst * rng.uniform(0.5, 0.999)
            worst = 1.0 - climb(tree, lower, upper, lambda M: lemma1_norm(M, mbar), seed)
    return Question(tree, lower, upper, mbar, kind, worst) if worst > 1e-5 else None


def proven_in_one_box(asked: Question, x: float) -> bool:
    """Whether the prover takes the statement at x over the box without halving it."""
    if x <= 0.0 or (asked.kind in ("bounded", "level") and x >= 1.0):
        return False
    problem = problem_of(asked.tree, asked.lower, asked.upper, asked.mbar, asked.statement(x))
    stack = np.zeros((4, asked.tree.nv), dtype=np.int64)
    hint, record = np.array([255], dtype=np.uint8), np.empty(4, dtype=np.uint8)
    return bool(explore(problem, stack, stack.copy(), 1, hint, 1, record)[0] == DONE)


def largest_proven(asked: Question, proven: Callable[[Question, float], bool], steps: int = 22) -> float:
    """The largest x that is proven, by bisection up to half as much again as is true."""
    low, high = 0.0, 1.5 * asked.worst
    for _ in range(steps):
        x = 0.5 * (low + high)
        low, high = (x, high) if proven(asked, x) else (low, x)
    return low


def norms(condition: str) -> Callable[[Array, Array], Array]:
    """The condition's norm."""
    return {"lemma1": lemma1_norm, "weighted": weighted_norm}[condition]
