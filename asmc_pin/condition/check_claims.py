"""What a certificate says of itself, derived again from its statements; and its counter-examples, evaluated again."""

from __future__ import annotations

import hashlib
import math
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.certificate.file import array, digest
from asmc_pin.condition.check_arm import Chain, Unreadable, chain_of_text

_NEAR = 1e-9


def fingerprints(header: dict[str, Any], urdf: str, records: list[Any]) -> list[str]:
    """Whether the file is as it was written, and the URDF the one it was written for."""
    found = []
    if digest(header, urdf, records) != header.get("digest"):
        found.append("the file is not as it was written: its digest is another")
    if hashlib.sha256(urdf.encode()).hexdigest() != header["urdf_sha256"]:
        found.append("the URDF in the file is not the one whose hash it gives")
    if len(records) != len(header["statements"]):
        found.append(f"{len(header['statements'])} statements, but {len(records)} records of proofs")
    return found


def chains(header: dict[str, Any], urdf: str) -> list[Chain]:
    """The arm of each case, from the URDF's text, compared with inertia matrices that the prover's arm had.

    Raises:
        Unreadable: It cannot be read, or is another arm.
    """
    found = []
    for case in header["cases"]:
        locked = {name: float.fromhex(angle) for name, angle in case["locked"].items()}
        payload = case["payload"]
        if payload is not None:
            payload = {
                "mass": float.fromhex(payload["mass"]),
                "com": array(payload["com"]),
                "inertia": array(payload["inertia"]),
                "link": payload["link"],
            }
        chain = chain_of_text(urdf, header["joints"], locked, payload)
        q, mass = array(case["sample_q"]), array(case["sample_mass"])
        ours = chain.mass_matrix(q, np.zeros(q.shape[1]))
        if np.abs(ours - mass).max() > _NEAR * np.abs(mass).max():
            raise Unreadable("the URDF in the file, read anew, is another arm than the one that the proof is of")
        found.append(chain)
    return found


def numbers_of(header: dict[str, Any]) -> dict[str, Any]:
    """The figures that a certificate claims, NaN where the header is damaged."""

    def number(key: str) -> float:
        value = header.get(key)
        return float(value) if isinstance(value, int | float) else math.nan

    try:
        mbar = tuple(float(x) for x in array(header["mbar"]))
    except (KeyError, TypeError, ValueError):
        mbar = ()
    try:
        ends = [np.array([array(case[end]) for case in header["cases"]]) for end in ("lower", "upper")]
        box = {
            name: (float(a), float(b))
            for name, a, b in zip(header["joints"], ends[0].min(axis=0), ends[1].max(axis=0), strict=True)
        }
    except (KeyError, TypeError, ValueError, IndexError):
        box = {}
    return {
        "box": box,
        "mbar": mbar,
        "scale_proven": number("scale_proven"),
        "scale_refuted": number("scale_refuted"),
        "lower": number("lower"),
        "upper": None if header.get("upper") is None else number("upper"),
    }


def claims(header: dict[str, Any]) -> list[str]:
    """Claims that do not follow from the statements, were they all true."""
    found = []
    mbar = array(header["mbar"])
    if not (np.all(np.isfinite(mbar)) and np.all(mbar > 0.0)):
        found.append("M̄ is not positive")
    weighted = header["condition"] == "weighted"
    if header["condition"] not in ("weighted", "lemma1"):
        found.append(f"'{header['condition']}' is no condition")
    for index, case in enumerate(header["cases"]):
        own = [s for s in header["statements"] if s["case"] == index]
        low, high = array(case["armature_lower"]), array(case["armature_upper"])
        if header["scale_proven"] > 0.0 and not any(
            s["kind"] == ("weighted" if weighted else "lemma1")
            and s["level"] == 1.0
            and s["scale"] >= header["scale_proven"]
            and np.all(array(s["armature"]) <= low)
            for s in own
        ):
            found.append(f"nothing in the file proves the scale {header['scale_proven']:.9g}")
        upper = header["upper"]
        if upper is not None and upper < 1.0:
            at = [s for s in own if s["scale"] == 1.0 and s["level"] <= upper]
            proven = _weighted_level(at, low, high) if weighted else _lemma1_level(at, low, high)
            if not proven:
                found.append(f"nothing in the file proves the level {upper:.9g}")
    if header["upper"] is not None and header["upper"] >= 1.0 and header["scale_proven"] < 1.0:
        found.append("it says that the norm is below 1 and has no proof for M̄ itself")
    if header["verdict"] == "holds" and (header["upper"] is None or header["upper"] > header["level"]):
        found.append("it says 'holds' and its bound of the norm does not")
    return found


def _weighted_level(statements: list[dict[str, Any]], low: Array, high: Array) -> bool:
    below = any(s["kind"] == "weighted" and np.all(array(s["armature"]) <= low) for s in statements)
    above = any(s["kind"] == "bounded" and np.all(array(s["armature"]) + array(s["slack"]) >= high) for s in statements)
    return below and above


def _lemma1_level(statements: list[dict[str, Any]], low: Array, high: Array) -> bool:
    statements = [s for s in statements if s["kind"] == "level"]
    if any(
        np.all(array(s["armature"]) == low) and np.all(array(s["armature"]) + array(s["slack"]) >= high)
        for s in statements
    ):
        return True
    proven = {array(s["armature"]).tobytes() for s in statements}
    ends = [(a,) if a == b else (a, b) for a, b in zip(low.tolist(), high.tolist(), strict=True)]
    return all(np.array(corner).tobytes() in proven for corner in product(*ends))


def counter_examples(header: dict[str, Any], arms: list[Chain]) -> list[str]:
    """Refutations that, evaluated again, are none."""
    found = []
    mbar = array(header["mbar"])
    weighted = header["condition"] == "weighted"
    seen = header["refuted"]
    mass = _mass_of(header, arms, seen)
    f = float(header["scale_refuted"])
    # The condition at f M̄, as a matrix that a violation makes indefinite.
    inverse = 1.0 / mbar
    if weighted:
        P = mass / np.sqrt(np.outer(mbar, mbar)) - 0.5 * f * np.eye(mbar.size)
    else:
        P = mass * (inverse[:, None] + inverse) - f * np.eye(mbar.size)
    if np.linalg.eigvalsh(P)[0] > 1e-11 * np.abs(P).max():
        found.append(f"the counter-example to the scale {f:.9g} is none")
    A = np.linalg.solve(_mass_of(header, arms, header["worst"]), np.diag(mbar))
    if weighted:
        root = np.sqrt(mbar)
        norm = float(np.abs(1.0 - np.linalg.eigvals(A * root[:, None] / root).real).max())
    else:
        norm = float(np.linalg.norm(np.eye(mbar.size) - A, 2))
    if abs(norm - header["lower"]) > 1e-6 * max(norm, 1.0):
        found.append(f"the norm at the worst configuration is {norm:.9g}, not {header['lower']:.9g}")
    if header["verdict"] == "violated" and norm < header["level"] - 1e-9 and f > 1.0:
        found.append("it says 'violated' and shows no violation")
    return found


def _mass_of(header: dict[str, Any], arms: list[Chain], seen: dict[str, Any]) -> Array:
    case = header["cases"][seen["case"]]
    q, armature = array(seen["q"]), array(seen["armature"])
    # Joints that carry the whole arm do not matter; all else has to be inside.
    free = arms[seen["case"]].parent >= 0
    inside = (q >= array(case["lower"]) - _NEAR) & (q <= array(case["upper"]) + _NEAR)
    ranged = (armature >= array(case["armature_lower"]) - _NEAR) & (armature <= array(case["armature_upper"]) + _NEAR)
    if not (np.all(inside[free]) and np.all(ranged)):
        raise ValueError("a counter-example lies outside the joint box or the armature's range")
    mass: Array = arms[seen["case"]].mass_matrix(q, armature)
    return mass


def exactly_positive(statement: dict[str, Any], mass: Array, mbar: Array) -> bool:
    """A statement at one inertia matrix, all numbers taken as the fractions that they are, by LDLᵀ."""
    n = mbar.size
    M = [[Fraction(float(x)) for x in row] for row in 0.5 * (mass + mass.T)]
    m = [Fraction(float(x)) for x in mbar]
    f, gamma = Fraction(float(statement["scale"])), Fraction(float(statement["level"]))
    unit = [[Fraction(int(i == j)) for j in range(n)] for i in range(n)]
    if statement["kind"] == "weighted":
        P = [[M[i][j] - unit[i][j] * f * m[i] / (1 + gamma) for j in range(n)] for i in range(n)]
    elif statement["kind"] == "bounded":
        P = [[unit[i][j] * f * m[i] / (1 - gamma) - M[i][j] for j in range(n)] for i in range(n)]
    else:
        P = [[M[i][j] / m[i] + M[i][j] / m[j] - unit[i][j] * f for j in range(n)] for i in range(n)]
        if statement["kind"] == "level":
            # Schur complement of f I: f (N M + M N − f I) − (1 − γ²) N M M N.
            S = [[sum((M[i][k] * M[k][j] for k in range(n)), Fraction(0)) for j in range(n)] for i in range(n)]
            P = [[f * P[i][j] - (1 - gamma * gamma) * S[i][j] / (m[i] * m[j]) for j in range(n)] for i in range(n)]
    for k in range(n):
        if P[k][k] <= 0:
            return False
        for i in range(k + 1, n):
            factor = P[i][k] / P[k][k]
            for j in range(k + 1, n):
                P[i][j] -= factor * P[k][j]
    return True
