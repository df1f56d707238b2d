"""`asmc-pin check`: replays a certificate by two other routes.

The file is believed in nothing. A strict schema reads it (`contents`); the arm comes from the URDF's text
(`urdf_text`), and what is proven is said of that arm (`subject`); the cells are counted as integers (`bisection`);
every cell is proven anew by other arithmetic (`box_bounds`); some, the hardest among them, are put to the condition
itself in ball arithmetic (`spot_checks`); and what follows is derived from the statements (`conclusions`).
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from flint import arb, ctx

from asmc_pin.condition.certificate.container import Container, digest, read
from asmc_pin.condition.checker.balls.balls import PRECISIONS, BallArm
from asmc_pin.condition.checker.balls.gravity_gain import small_gain_holds, stiffness_in_balls
from asmc_pin.condition.checker.balls.rayleigh import eigenvalues_seen
from asmc_pin.condition.checker.balls.velocity_forces import velocity_forces_in_balls
from asmc_pin.condition.checker.balls.witness import witness
from asmc_pin.condition.checker.bounds_conclusion import BoundsConclusion, conclude_bounds
from asmc_pin.condition.checker.boxes.bisection import Broken
from asmc_pin.condition.checker.boxes.statements import replay_statement
from asmc_pin.condition.checker.conclusions import Conclusion, conclude, disagreements
from asmc_pin.condition.checker.loop_conclusion import LoopConclusion, conclude_loop
from asmc_pin.condition.checker.outcome import CheckedStatement, CheckResult
from asmc_pin.condition.checker.reading.certificate_schema import (
    BoundsContents,
    Contents,
    GravityClaim,
    LoopContents,
    contents,
)
from asmc_pin.condition.checker.reading.header_parts import Header, Malformed
from asmc_pin.condition.checker.reading.link_chain import Chain, chain_of
from asmc_pin.condition.checker.reading.subject import Subject, subject
from asmc_pin.condition.checker.reading.urdf_text import Unreadable, description

_SAME = 1e-9
"""How far the inertia matrices that the certificate states may be from those of the URDF in it."""

_MOST_BODIES = 100_000
"""Links of all different arms of a certificate together."""

_UNSOUND = (Malformed, Unreadable, Broken)
"""What a file that is no valid certificate comes to, with a message."""


@dataclass(frozen=True, eq=False)
class _Arms:
    """The arm of each case, for either arithmetic."""

    chains: list[Chain]
    balls: list[BallArm]
    about: Subject


def check(path: str | Path, *, progress: Callable[[str, float], None] | None = None) -> CheckResult:
    """Check a certificate: prove its statements again by other routes, and derive from them what follows.

    Args:
        path: The file that `CertificateResult.save` wrote.
        progress: Called with what is being done and the share of it that is done.

    Returns:
        Whether it is valid, and why not.

    Raises:
        ResultError: No such file, or no certificate at all.
    """
    began = time.perf_counter()
    container = read(path)
    problems: list[str] = []
    checked: list[CheckedStatement] = []
    about: Subject | None = None
    conclusion: Conclusion | BoundsConclusion | LoopConclusion | None = None
    try:
        told = contents(container.header)
        problems += _fingerprints(container, told)
        # Numbers of any size may stand in a stranger's file; what overflows proves nothing.
        with np.errstate(all="ignore"):
            arms = _arms(told, container.urdf)
            about = arms.about
            found, claims = _conclusion(told, arms)
            problems += claims
            # What fails already is not worth the hours that its proof may take.
            if not problems:
                problems += _statements(container, told, arms, checked, progress)
        conclusion = found if not problems else None
    except (np.linalg.LinAlgError, ArithmeticError) as error:
        problems.append(f"its numbers cannot be evaluated ({error})")
    except _UNSOUND as error:
        problems.append(str(error))
    return CheckResult(
        path=str(path),
        valid=conclusion is not None,
        problems=tuple(problems),
        hypotheses=about.hypotheses if about is not None and conclusion is not None else None,
        conclusion=conclusion,
        statements=tuple(checked),
        seconds=time.perf_counter() - began,
    )


def _conclusion(told: Header, arms: _Arms) -> tuple[Conclusion | BoundsConclusion | LoopConclusion, list[str]]:
    """What follows if every statement is true, and what the header claims beyond it, a sentence each."""
    if isinstance(told, BoundsContents):
        with ctx.workprec(PRECISIONS[0]):
            weights = [1 / arb(s) ** 2 for s in told.scaling]

        def forces(largest: float | None) -> float | None:
            if told.moving:  # the bound is one of joints that move freely
                return None
            ends = zip(told.cases, arms.balls, strict=True)
            return max(velocity_forces_in_balls(arm, c.lower, c.upper, told.scaling, largest) for c, arm in ends)

        return conclude_bounds(told, eigenvalues_seen(told, weights, arms.balls, arms.chains), forces)
    if isinstance(told, LoopContents):
        weights = [arb(m) for m in told.mbar]

        def resists(claim: GravityClaim) -> bool:
            if told.moving:
                return False
            ends = zip(told.cases, arms.balls, strict=True)
            springs = [stiffness_in_balls(arm, c.lower, c.upper, told.mbar, claim.magnitude) for c, arm in ends]
            return small_gain_holds(told, claim.pieces, max(springs))

        return conclude_loop(told, eigenvalues_seen(told, weights, arms.balls, arms.chains), resists)
    assert isinstance(told, Contents)
    found = conclude(told, witness(told, arms.balls, arms.chains))
    return found, disagreements(told, found)


def _fingerprints(container: Container, told: Header) -> list[str]:
    """Whether the file is as it was written, and the URDF the one it was written for."""
    found = []
    if digest(container.header, container.urdf, container.records) != told.digest:
        found.append("the file is not as it was written: its digest is another")
    if hashlib.sha256(container.urdf.encode()).hexdigest() != told.urdf_sha256:
        found.append("the URDF in the file is not the one whose hash it gives")
    if len(container.records) != len(told.statements):
        found.append(f"{len(told.statements)} statements, but {len(container.records)} records of proofs")
    return found


def _arms(told: Header, urdf: str) -> _Arms:
    """The arm of each case from the URDF's text, compared with inertia matrices that the prover's arm had.

    Raises:
        Unreadable: It cannot be read, or is another arm.
        Malformed: The cases are no ranges.
    """
    robot = description(urdf)
    chains, balls = [], []
    known: dict[tuple[object, ...], Chain] = {}
    for case in told.cases:
        key = (*sorted(case.locked.items()), case.load)
        if key not in known:
            if (len(known) + 1) * len(robot.bodies) > _MOST_BODIES:
                raise Unreadable(f"its cases have more than {_MOST_BODIES} links together")
            known[key] = chain_of(robot, told.joints, case.locked, case.load, told.moving)
        chain = known[key]
        mass = np.array(case.sample_mass)
        ours = chain.arm_mass(np.array(case.sample_q))
        if not np.abs(ours - mass).max() <= _SAME * np.abs(mass).max():
            raise Unreadable("the URDF in the file, read anew, is another arm than the one that the proof is of")
        chains.append(chain)
        balls.append(BallArm(robot, told.joints, case.locked, case.load, told.moving))
    return _Arms(chains, balls, subject(told, urdf, robot, chains[0]))


def _statements(
    container: Container,
    told: Header,
    arms: _Arms,
    checked: list[CheckedStatement],
    progress: Callable[[str, float], None] | None,
) -> list[str]:
    """Prove all statements again; what is wrong with the first that fails."""
    count = len(told.statements)
    for number, (statement, record) in enumerate(zip(told.statements, container.records, strict=True)):
        label = f"statement {number + 1} of {count}"

        def tell(share: float, label: str = label) -> None:
            if progress is not None:
                progress(label, share)

        case = statement.case
        chain, balls, words = arms.chains[case], arms.balls[case], arms.about.labels[case]
        result, problem = replay_statement(told, statement, record, chain, balls, words, number, tell)
        checked.append(result)
        if problem:
            return [f"{label}: {problem}"]
    return []
