"""`asmc-pin check`: replays a certificate by another route.

Nothing of the prover is used but the reading of the file: the arm comes from the URDF's text (`check_arm`), the cells
are counted as integers (`check_cover`), every cell is proven anew by other arithmetic (`check_bound`), what the
certificate claims is derived again from its statements (`check_claims`), and some configurations are put to the
condition in exact fractions.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.certificate.file import array, read
from asmc_pin.condition.check_arm import Chain, Unreadable
from asmc_pin.condition.check_bound import WIDE, holds
from asmc_pin.condition.check_claims import chains, claims, counter_examples, exactly_positive, fingerprints, numbers_of
from asmc_pin.condition.check_cover import Broken, cells
from asmc_pin.condition.check_form import Form, form_of

_ROOM = 4_000_000
"""Numbers in the largest array of one batch."""

_DEEPER = 14
"""How often a cell that this route does not prove as it is may be halved on."""

_MORE = 20.0
"""How many more boxes than the certificate has it may take."""

_NEAR = 1e-10
"""Least eigenvalue over the largest that is below zero for sure."""


@dataclass(frozen=True)
class CheckedStatement:
    """One statement of a certificate.

    Attributes:
        kind: As in docs/certificate.md: ``weighted``, ``bounded``, ``lemma1``, ``level``.
        scale: f.
        level: γ.
        case: Which of the arms, in words; empty where there is one.
        boxes: Leaves of its bisection.
        halved: How many more this route needed.
        proven: Whether all are proven.
    """

    kind: str
    scale: float
    level: float
    case: str
    boxes: int
    halved: int
    proven: bool


@dataclass(frozen=True)
class CheckResult:
    """What replaying a certificate came to.

    Attributes:
        path: The file.
        valid: Whether all that it claims was proven again.
        problems: Why not, one sentence each.
        arm: The arm it speaks of.
        sha256: Hash of the URDF in it.
        condition: ``lemma1`` or ``weighted``.
        mbar: Diagonal of M̄, kg·m².
        verdict: What it claims: ``holds``, ``violated`` or ``undecided``.
        scale_proven: What it claims.
        scale_refuted: What it claims.
        upper: What it claims.
        lower: What it claims.
        box: The joint box that it speaks of, by joint, rad (m where prismatic); for a tube, all its slices together.
        statements: Its statements.
        fractions: Configurations at which they were also evaluated in exact fractions.
        seconds: Wall time.
    """

    path: str
    valid: bool
    problems: tuple[str, ...]
    arm: str
    sha256: str
    condition: str
    mbar: tuple[float, ...]
    verdict: str
    scale_proven: float
    scale_refuted: float
    upper: float | None
    lower: float
    box: dict[str, tuple[float, float]]
    statements: tuple[CheckedStatement, ...]
    fractions: int
    seconds: float

    def to_json_dict(self) -> dict[str, Any]:
        """The object that ``asmc-pin check --json`` prints."""
        content = {**self.__dict__, "problems": list(self.problems), "mbar": list(self.mbar)}
        content["statements"] = [dict(statement.__dict__) for statement in self.statements]
        return content

    def lines(self) -> list[str]:
        """The same for a person to read."""
        claim = f"M̄ × {self.scale_proven:.6g} proven, M̄ × {self.scale_refuted:.6g} refuted"
        if self.upper is not None:
            claim += f", norm between {self.lower:.6g} and {self.upper:.6g}"
        found = [
            f"{self.path}: {'valid' if self.valid else 'NOT VALID'}",
            f"arm {self.arm} (URDF {self.sha256[:16]}…), condition {self.condition}: {self.verdict}; {claim}",
        ]
        if self.box:
            ranges = ", ".join(f"{name} {lo:.4g}:{hi:.4g}" for name, (lo, hi) in self.box.items())
            boxes = len({s.case for s in self.statements})
            found.append(f"joint box: {ranges}" + (f" ({boxes} cases, some with parts of it)" if boxes > 1 else ""))
        for s in self.statements:
            where = f" ({s.case})" if s.case else ""
            found.append(
                f"  {s.kind}, scale {s.scale:.6g}, level {s.level:.6g}{where}: {s.boxes} boxes cover the joint box, "
                f"{'all proven again' if s.proven else 'not all proven again'} ({s.halved} halved further)"
            )
        found.append(f"  {self.fractions} configurations evaluated in exact fractions; {self.seconds:.1f} s")
        return found + [f"problem: {problem}" for problem in self.problems]


def check(path: str | Path, *, progress: Callable[[str, float], None] | None = None) -> CheckResult:
    """Replay a certificate.

    Args:
        path: The file that `CertificateResult.save` wrote.
        progress: Called with what is being done and the share of it that is done.

    Returns:
        Whether it is valid, and why not.

    Raises:
        ResultError: No such file, or no certificate at all.
    """
    began = time.perf_counter()
    header, urdf, records = read(path)
    problems: list[str] = []
    checked: list[CheckedStatement] = []
    fractions = 0
    try:
        problems += fingerprints(header, urdf, records)
        arms = chains(header, urdf)
        problems += claims(header) + counter_examples(header, arms)
        for number, (statement, record) in enumerate(zip(header["statements"], records, strict=True)):
            label = f"statement {number + 1} of {len(records)}"

            def tell(share: float, label: str = label) -> None:
                if progress is not None:
                    progress(label, share)

            result, problem, count = _statement(header, arms, statement, record, tell)
            checked.append(result)
            fractions += count
            problems += [f"{label}: {problem}"] if problem else []
    except (Unreadable, Broken) as error:
        problems.append(str(error))
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, np.linalg.LinAlgError) as error:
        problems.append(f"the header is not what a certificate has ({type(error).__name__}: {error})")
    return CheckResult(
        path=str(path),
        valid=not problems,
        problems=tuple(problems),
        arm=str(header.get("arm")),
        sha256=str(header.get("sha256")),
        condition=str(header.get("condition")),
        verdict=str(header.get("verdict")),
        **numbers_of(header),
        statements=tuple(checked),
        fractions=fractions,
        seconds=time.perf_counter() - began,
    )


def _statement(
    header: dict[str, Any], arms: list[Chain], statement: dict[str, Any], record: Any, tell: Callable[[float], None]
) -> tuple[CheckedStatement, str, int]:
    """Prove one statement again; what came of it, what is wrong with it, and how many fractions were tried."""
    case = header["cases"][statement["case"]]
    chain, mbar = arms[statement["case"]], array(header["mbar"])
    lower, upper = array(case["lower"]), array(case["upper"])
    form = form_of(chain, mbar, statement, lower, upper)
    leaves = cells(record, mbar.size)
    centre, half = leaves.boxes(lower, upper)
    halved, problem = _prove(form, centre, half, tell)
    count = 0
    if not problem:
        rng = np.random.default_rng(0)
        chosen = rng.integers(0, len(centre), 16)
        q = centre[chosen] + half[chosen] * rng.uniform(-1.0, 1.0, (16, mbar.size))
        for mass in chain.mass_matrix(q, array(statement["armature"])):
            count += 1
            if not exactly_positive(statement, mass, mbar):
                problem = "at a configuration of its box it is not so, in exact fractions"
    result = CheckedStatement(
        str(statement["kind"]),
        float(statement["scale"]),
        float(statement["level"]),
        str(case["label"]),
        len(centre),
        halved,
        not problem,
    )
    return result, problem, count


def _prove(form: Form, centre: Array, half: Array, tell: Callable[[float], None]) -> tuple[int, str]:
    """Prove all boxes, halving where that takes it; how many times, and what could not be proven."""
    n = centre.shape[1]
    idle = form.chain.parent < 0
    if form.exact:
        idle = idle.copy()
        idle[1] = True
    half = np.where(idle, 0.0, half)
    waiting = [(centre, half, np.zeros(len(centre), dtype=np.int64))]
    halved, done, total = 0, 0.0, float(len(centre))
    while waiting:
        c, r, depth = waiting.pop()
        # Boxes of a batch have the same joints wide, so that they have the same corners.
        code = (r > WIDE) @ (1 << np.arange(n))
        for value in np.unique(code):
            same = np.flatnonzero(code == value)
            corners = 2 ** int(np.count_nonzero(~idle & (r[same[0]] <= WIDE)))
            batch = max(1, _ROOM // (corners * (6 * form.pairing.shape[0]) ** 2))
            for start in range(0, same.size, batch):
                at = same[start : start + batch]
                good, cost, least = holds(form, c[at], r[at])
                done += float(np.sum(np.exp2(-depth[at[good]].astype(np.float64))))
                tell(done / total)
                if good.all():
                    continue
                if np.any(least[~good] < -_NEAR):
                    return halved, "at the centre of a box it is not so"
                at, cost = at[~good], cost[~good]
                joint = np.argmax(np.where(r[at] > 0.0, np.nan_to_num(cost, nan=np.inf) + 1e-300, -1.0), axis=1)
                if np.any(depth[at] >= _DEEPER) or np.all(idle) or halved > _MORE * (total + 100.0):
                    return halved, "a box of it could not be proven again"
                halved += at.size
                rows = np.arange(at.size)
                narrow, left, right = r[at].copy(), c[at].copy(), c[at].copy()
                narrow[rows, joint] = 0.5 * narrow[rows, joint] * (1.0 + 1e-14)
                left[rows, joint] -= narrow[rows, joint]
                right[rows, joint] += narrow[rows, joint]
                deeper = np.repeat(depth[at] + 1, 2)
                both = np.stack((left, right), axis=1).reshape(-1, n), np.repeat(narrow, 2, axis=0)
                waiting.append((*both, deeper))
    return halved, ""
