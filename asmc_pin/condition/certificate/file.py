"""Writing a certificate: one file with all that a proof rests on; `container` says what stands in it."""

from __future__ import annotations

import hashlib
import io
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.condition.certificate.container import (
    FORMAT,
    MOST_HEADER,
    MOST_RECORDS,
    MOST_STATEMENTS,
    MOST_URDF,
    digest,
    numbers,
)
from asmc_pin.errors import ResultError
from asmc_pin.files import write_whole

if TYPE_CHECKING:
    from asmc_pin.condition.certificate.result import CertificateResult
    from asmc_pin.condition.variants import Case


def write(result: CertificateResult, path: str | Path) -> Path:
    """Write a certificate; see `CertificateResult.save`."""
    target = Path(path)
    if not result.proofs and result.verdict != "violated":
        raise ResultError(
            target, f"nothing is proven about {result.arm} ({result.reason}), so there is nothing to write"
        )
    records = [proof.record for proof in result.proofs]
    arm = result.cases[0].domain.arm
    header: dict[str, Any] = {
        "format": FORMAT,
        "arm": result.arm,
        "source": arm.source.name,
        "sha256": arm.sha256,
        "urdf_sha256": hashlib.sha256(arm.urdf_text.encode()).hexdigest(),
        "joints": list(result.joints),
        "condition": result.condition,
        "mbar": numbers(result.mbar),
        "verdict": result.verdict,
        "level": result.level,
        "upper": result.upper,
        "scale_proven": result.scale_proven,
        "scale_refuted": result.scale_refuted,
        "lower": result.lower,
        "worst": _seen(result.worst_q, result.worst_armature, result.worst_index),
        "refuted": _seen(result.refuted_q, result.refuted_armature, result.refuted_index),
        "cases": [_case(case) for case in result.cases],
        "statements": [
            {
                "kind": proof.statement.kind,
                "scale": proof.statement.scale,
                "level": proof.statement.level,
                "case": proof.statement.case,
                "armature": numbers(proof.statement.armature),
                "slack": numbers(proof.statement.slack),
            }
            for proof in result.proofs
        ],
    }
    header["digest"] = digest(header, arm.urdf_text, records)
    content = {f"record_{k}": record for k, record in enumerate(records)}
    text = json.dumps(header, ensure_ascii=False, allow_nan=False)
    content["header"] = np.frombuffer(text.encode(), dtype=np.uint8)
    content["urdf"] = np.frombuffer(arm.urdf_text.encode(), dtype=np.uint8)
    _check_sizes(target, content, len(records))
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **content)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ResultError(target, f"cannot write the certificate {target}: {error.strerror}") from None
    write_whole(target, buffer.getvalue())
    return target


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


def _seen(q: Array, armature: Array, case: int) -> dict[str, Any]:
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
