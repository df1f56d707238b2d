"""Arms, forms, headers and exact arithmetic for the tests of the checker."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
from condition_cases import chain_urdf

from asmc_pin._typing import Array
from asmc_pin.condition.certificate.container import FORMAT
from asmc_pin.condition.checker.balls.balls import BallArm
from asmc_pin.condition.checker.boxes.quadratic_form import Form
from asmc_pin.condition.checker.reading.certificate_schema import Contents, contents
from asmc_pin.condition.checker.reading.header_parts import WrittenCase, WrittenStatement
from asmc_pin.condition.checker.reading.link_chain import Chain, chain_of, cross
from asmc_pin.condition.checker.reading.urdf_text import description

KINDS = ("weighted", "bounded", "lemma1", "level")
ZERO = "0x0.0p+0"


def hexed(values: Any) -> Any:
    """Nested lists of hexadecimal floats."""
    if isinstance(values, (list, tuple, np.ndarray)):
        return [hexed(value) for value in values]
    return float(values).hex()


def condition_of(kind: str) -> str:
    return "weighted" if kind in ("weighted", "bounded") else "lemma1"


def arm(seed: int, joints: int, prismatic: bool = False) -> tuple[Chain, BallArm]:
    """A random serial chain in both of the checker's arithmetics."""
    robot = description(chain_urdf(seed, joints, prismatic))
    names = [f"j{i}" for i in range(joints)]
    return chain_of(robot, names, {}, None), BallArm(robot, names, {}, None)


def case(n: int, **changes: Any) -> dict[str, Any]:
    """A case of a header; numbers may be given as floats."""
    said = {
        "locked": {},
        "lower": [-1.0] * n,
        "upper": [1.0] * n,
        "armature_lower": [0.0] * n,
        "armature_upper": [0.0] * n,
        **changes,
    }
    said["locked"] = {name: hexed(value) for name, value in said["locked"].items()}
    rows = {key: hexed(said[key]) for key in ("lower", "upper", "armature_lower", "armature_upper")}
    sample = {"sample_q": [[ZERO] * n], "sample_mass": [[[ZERO] * n] * n]}
    return {"label": "", "payload": None, **sample, **said, **rows}


def statement(n: int, kind: str = "weighted", **changes: Any) -> dict[str, Any]:
    """A statement of a header; numbers may be given as floats."""
    said = {
        "kind": kind,
        "scale": 1.0,
        "level": 0.5 if kind in ("bounded", "level") else 1.0,
        "case": 0,
        "armature": [0.0] * n,
        "slack": [0.0] * n,
        **changes,
    }
    return {**said, "armature": hexed(said["armature"]), "slack": hexed(said["slack"])}


def header(n: int = 2, **changes: Any) -> dict[str, Any]:
    """A header that the schema takes."""
    seen = {"case": 0, "q": [ZERO] * n, "armature": [ZERO] * n}
    return {
        "format": FORMAT,
        "arm": "",
        "source": "",
        "sha256": "",
        "urdf_sha256": "",
        "joints": [f"j{i}" for i in range(n)],
        "condition": "weighted",
        "mbar": ["0x1.0p+0"] * n,
        "verdict": "holds",
        "level": 1.0,
        "upper": None,
        "scale_proven": 0.5,
        "scale_refuted": 2.0,
        "lower": 0.5,
        "worst": seen,
        "refuted": dict(seen),
        "cases": [case(n)],
        "statements": [statement(n)],
        "digest": "",
        **changes,
    }


def told(n: int = 2, **changes: Any) -> Contents:
    return contents(header(n, **changes))


def parsed_statement(n: int, kind: str, **changes: Any) -> WrittenStatement:
    made = told(n, condition=condition_of(kind), statements=[statement(n, kind, **changes)])
    return made.statements[0]


def parsed_case(n: int, **changes: Any) -> WrittenCase:
    return told(n, cases=[case(n, **changes)], statements=[]).cases[0]


def exact(A: Any) -> list[list[Fraction]]:
    """A matrix of floats as the numbers that they are."""
    return [[Fraction(float(x)) for x in row] for row in np.asarray(A)]


def is_positive(A: list[list[Fraction]], least: Fraction = Fraction(0)) -> bool:
    """Whether a symmetric matrix of fractions, less `least` times the identity, is positive definite: no rounding."""
    rows = [[value - least * (i == j) for j, value in enumerate(row)] for i, row in enumerate(A)]
    n = len(rows)
    for k in range(n):
        if rows[k][k] <= 0:
            return False
        for i in range(k + 1, n):
            factor = rows[i][k] / rows[k][k]
            rows[i] = [rows[i][j] - factor * rows[k][j] if j > k else Fraction(0) for j in range(n)]
    return True


def plus(A: Any, B: Any, sign: int = 1) -> list[list[Fraction]]:
    return [[x + sign * y for x, y in zip(a, b, strict=True)] for a, b in zip(exact(A), exact(B), strict=True)]


def random_form(rng: np.random.Generator, m: int) -> Array:
    """A symmetric matrix: positive, of low rank, indefinite, or with parts of very different size."""
    kind = rng.integers(4)
    A = rng.normal(size=(m, m if kind != 1 else 2))
    A = A @ A.T if kind < 2 else A + A.T
    scale = 10.0 ** rng.uniform(-3.0, 3.0, m) if kind == 3 else np.ones(m)
    out: Array = A * scale[:, None] * scale
    return np.tril(out) + np.tril(out, -1).T


def random_metric(rng: np.random.Generator, m: int) -> tuple[Array, Array]:
    """A square root of a metric, and its inverse."""
    root = np.linalg.qr(rng.normal(size=(m, m)))[0] * 10.0 ** rng.uniform(-1.0, 1.0, m)
    return root, np.linalg.inv(root)


def two_joints(p: int = 1, e: int = 1, slides: bool = False, exact: bool = False, **own: Any) -> Form:
    """A form of two joints in general position; of two twists where p = 2."""
    place = np.broadcast_to(np.eye(4), (2, 4, 4)).copy()
    place[1, :3, 3] = (0.3, 0.1, -0.2)
    axis = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]])
    body = np.eye(6)
    body[:3, 3:] = cross(np.array([0.1, -0.05, 0.2]))
    body[3:, :3] = body[:3, 3:].T
    body[:3, :3] += 0.1 * np.eye(3)
    chain = Chain(np.array([-1, 0]), place, axis, np.array([False, slides]), np.stack((body, 0.5 * body)))
    pairing = np.ones((1, 1)) if p == 1 else np.array([[0.0, 1.0], [1.0, 0.0]])
    none = np.zeros((2, e, e))
    given = own.get("own", none)
    size = own.get("own_size", np.abs(given).sum(axis=2))
    return Form(
        chain, pairing, np.ones((2, p, e)), given, size, exact, own.get("range_1", (0.0, 0.0)), *[np.zeros(2)] * 2
    )
