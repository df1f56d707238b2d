"""Certificates that were changed after they were written."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin.condition.certificate.container import digest, read


def rewrite(source: Path, target: Path, change: Callable[[dict[str, Any], list[Any]], None], sign: bool = True) -> Path:
    """A changed copy of a certificate, with a digest that fits again if `sign`."""
    container = read(source)
    header, urdf, records = container.header, container.urdf, container.records
    change(header, records)
    if sign:
        header["digest"] = digest(header, urdf, records)
    content = {f"record_{k}": record for k, record in enumerate(records)}
    content["header"] = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
    content["urdf"] = np.frombuffer(urdf.encode(), dtype=np.uint8)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **content)
    target.write_bytes(buffer.getvalue())
    return target
