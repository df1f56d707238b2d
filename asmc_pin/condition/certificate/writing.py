"""Writing a certificate: one file with all that a proof rests on; `container` says what stands in it."""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.certificate.compiled.bisection_tree import LEAF
from asmc_pin.condition.certificate.container import (
    FORMAT,
    MOST_HEADER,
    MOST_RECORDS,
    MOST_STATEMENTS,
    MOST_URDF,
    digest,
    numbers,
)
from asmc_pin.condition.certificate.statement import Statement
from asmc_pin.condition.certificate.walk import Record
from asmc_pin.condition.domain.payload_ranges import has_places
from asmc_pin.disk.files import write_whole
from asmc_pin.errors import ResultError
from asmc_pin.words.provisos import provisos_json
from asmc_pin.words.text import quoted

if TYPE_CHECKING:
    from asmc_pin.condition.domain.arm_ranges import Case


@dataclass(frozen=True, eq=False)
class Proof:
    """A proven statement: its box, halved as the record says, is positive in every leaf.

    Attributes:
        statement: What is proven.
        record: The bisections. Where joints mimic others, of each branch that of its box into pieces, and for each
            piece that of its joints' box.
        weights: Where joints mimic others, for each piece what every joint of its branch bears of m̄, kg·m² (kg).
    """

    statement: Statement
    record: Record
    weights: tuple[Array, ...] = ()

    @property
    def boxes(self) -> int:
        """How many boxes were proven; what only cuts a box into pieces is not counted."""
        return int(np.count_nonzero(self.record == LEAF)) - len(self.weights)


def unwritable(cases: Sequence[Case]) -> str:
    """Why no certificate can be of these arms; empty where one can."""
    arm = cases[0].domain.arm
    if has_places([case.domain.arm.payload for case in cases]):
        return "ranges of a payload's place are in no certificate"
    own = arm.made_of.robot.joints
    freed = [quoted(name) for name in arm.joint_names if own[name].mimic is not None]
    if freed:
        return f"no certificate has joints that mimic others in the URDF and were freed: {', '.join(freed)}"
    return ""


def write(path: Path, figures: dict[str, Any], cases: Sequence[Case], proofs: Sequence[Proof]) -> Path:
    """Write a certificate; see `CertificateResult.save`.

    Args:
        path: The file; an existing one is replaced.
        figures: What the header says besides what follows from the other arguments.
        cases: The arms that the statements speak of.
        proofs: Statements and how they are proven.

    Raises:
        ResultError: The checker could not read it, or it cannot be written.
    """
    if unwritable(cases):
        raise ResultError(path, unwritable(cases))
    records = [proof.record for proof in proofs]
    arm = cases[0].domain.arm
    header: dict[str, Any] = {
        "format": FORMAT,
        "arm": arm.name,
        "source": arm.source.name,
        "sha256": arm.sha256,
        "urdf_sha256": hashlib.sha256(arm.urdf_text.encode()).hexdigest(),
        "joints": list(arm.joint_names),
        # Likewise left out.
        **({"moving": list(arm.model.names)[1:]} if arm.mimics else {}),
        # Left out where there are none: such a certificate is the same as before there were any.
        **({"provisos": provisos_json(arm.provisos)} if arm.provisos else {}),
        **figures,
        "cases": [_case(case) for case in cases],
        "statements": [
            {
                "kind": proof.statement.kind,
                "scale": proof.statement.scale,
                "level": proof.statement.level,
                "case": proof.statement.case,
                "armature": numbers(proof.statement.armature),
                "slack": numbers(proof.statement.slack),
                **({"weights": [numbers(row) for row in proof.weights]} if proof.weights else {}),
            }
            for proof in proofs
        ],
    }
    header["digest"] = digest(header, arm.urdf_text, records)
    content = {f"record_{k}": record for k, record in enumerate(records)}
    text = json.dumps(header, ensure_ascii=False, allow_nan=False)
    content["header"] = np.frombuffer(text.encode(), dtype=np.uint8)
    content["urdf"] = np.frombuffer(arm.urdf_text.encode(), dtype=np.uint8)
    _check_sizes(path, content, len(records))
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **content)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ResultError(path, f"cannot write the certificate {path}: {error.strerror}") from None
    write_whole(path, buffer.getvalue())
    return path


def _check_sizes(target: Path, content: dict[str, Any], records: int) -> None:
    """A certificate that no checker would open is none."""
    sizes = (
        ("header", content["header"].size, MOST_HEADER, "bytes"),
        ("URDF", content["urdf"].size, MOST_URDF, "bytes"),
        ("proof", sum(content[f"record_{k}"].size for k in range(records)), MOST_RECORDS, "boxes"),
        ("proof", records, MOST_STATEMENTS, "statements"),
    )
    for what, size, most, unit in sizes:
        if size > most:
            raise ResultError(
                target,
                f"the certificate would not be readable: its {what} has {size} {unit}, at most {most} are read; "
                "ask for a larger gap, a smaller box, or fewer slices of a tube",
            )


def seen(q: Array, armature: Array, case: int) -> dict[str, Any]:
    """A configuration with its armature and case, as the header has it."""
    return {"case": case, "q": numbers(q), "armature": numbers(armature)}


def _case(case: Case) -> dict[str, Any]:
    domain = case.domain
    arm, box = domain.arm, domain.box
    payload = arm.payload
    share = np.random.default_rng(0).random((3, arm.nv))
    q = box.lower + share * (box.upper - box.lower)
    return {
        "label": case.label,
        "locked": {name: float(angle).hex() for name, angle in arm.locked.items()},
        "payload": None
        if payload is None
        else {
            "mass": float(payload.mass).hex(),
            "com": numbers(np.asarray(payload.com, dtype=np.float64)),
            "inertia": numbers(np.asarray(payload.inertia, dtype=np.float64)),
            "link": payload.link,
        },
        "lower": numbers(box.lower),
        "upper": numbers(box.upper),
        "armature_lower": numbers(domain.armature_lower),
        "armature_upper": numbers(domain.armature_upper),
        "sample_q": numbers(q),
        "sample_mass": numbers(arm.mass_matrix(q) - np.diag(arm.armature)),
    }
