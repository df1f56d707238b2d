"""A certificate on disk: one npz file with all that a proof rests on.

Content: ``header`` (JSON text), ``urdf`` (the URDF's text), ``record_K`` (the bisection of statement K, uint8). The
header holds the statements, the boxes, what was done to the arm (locked joints, payload, armature), some of its inertia
matrices, all as exact numbers (hexadecimal floats), and a digest of all else.
"""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from asmc_pin._typing import Array
from asmc_pin.errors import ResultError

if TYPE_CHECKING:
    from asmc_pin.condition.certificate.result import CertificateResult
    from asmc_pin.condition.variants import Case

FORMAT = "asmc-pin certificate 1"


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
    content["header"] = np.frombuffer(json.dumps(header, ensure_ascii=False).encode(), dtype=np.uint8)
    content["urdf"] = np.frombuffer(arm.urdf_text.encode(), dtype=np.uint8)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **content)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(buffer.getvalue())
    except OSError as error:
        raise ResultError(target, f"cannot write the certificate {target}: {error.strerror}") from None
    return target


def read(path: str | Path) -> tuple[dict[str, Any], str, list[np.ndarray[Any, np.dtype[np.uint8]]]]:
    """Header, URDF text and records of a certificate file, as they stand: nothing is believed yet.

    Raises:
        ResultError: No such file, or not a certificate.
    """
    source = Path(path)
    try:
        with np.load(io.BytesIO(source.read_bytes()), allow_pickle=False) as content:
            header = json.loads(content["header"].tobytes().decode())
            urdf = content["urdf"].tobytes().decode()
            count = sum(name.startswith("record_") for name in content.files)
            records = [np.array(content[f"record_{k}"], dtype=np.uint8).ravel() for k in range(count)]
    except OSError as error:
        raise ResultError(source, f"cannot read the certificate {source}: {error.strerror or error}") from None
    except (ValueError, KeyError, zipfile.BadZipFile, UnicodeDecodeError, EOFError):
        raise ResultError(
            source, f"{source} is not a certificate; write one with: asmc-pin verify … --certify --certificate FILE"
        ) from None
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        raise ResultError(source, f"{source} is not of the format '{FORMAT}', which is what this version checks")
    return header, urdf, records


def digest(header: dict[str, Any], urdf: str, records: list[np.ndarray[Any, np.dtype[np.uint8]]]) -> str:
    """SHA-256 of all that a certificate says, but for the digest itself."""
    said = {key: value for key, value in header.items() if key != "digest"}
    total = hashlib.sha256(json.dumps(said, sort_keys=True, ensure_ascii=False).encode())
    total.update(urdf.encode())
    for record in records:
        total.update(np.int64(record.size).tobytes() + record.tobytes())
    return total.hexdigest()


def numbers(values: Array) -> Any:
    """Nested lists of hexadecimal floats, exact."""
    if values.ndim == 0:
        return float(values).hex()
    return [numbers(row) for row in values]


def array(values: Any) -> Array:
    """The array that `numbers` wrote."""
    return np.array([array(row) for row in values]) if isinstance(values, list) else np.array(float.fromhex(values))


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
