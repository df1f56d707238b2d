"""Meshcat commands for one arm, made with Meshcat's own Python classes but without its server.

Meshcat numbers what it draws at random; here the numbers follow from the path: the same scene gives the same bytes.
"""

from __future__ import annotations

import base64
import uuid
from typing import Any

import numpy as np
import numpy.typing as npt

from asmc_pin.viewer.drawing.mesh_simplify import Shaded

_NAMESPACE = uuid.uuid5(uuid.NAMESPACE_URL, "asmc_pin.viewer")
_EXTENSION = {"Int8Array": 0x11, "Uint8Array": 0x12, "Int16Array": 0x13, "Uint16Array": 0x14, "Uint32Array": 0x16}
"""msgpack extension types of the typed arrays that Meshcat's page decodes."""

_STEPS = 32767


def mesh_command(path: str, mesh: Shaded, opacity: float = 1.0) -> str:
    """The command that puts a mesh at a path of the scene, packed for Meshcat and encoded in base64.

    Positions are rounded to 1/32767 of the mesh's reach, normals and colours to one byte: a fraction of
    Meshcat's own size.

    Args:
        path: Path below the arm, with slashes.
        mesh: What to draw, in the frame at that path.
        opacity: 1 where nothing behind it is seen.
    """
    # Meshcat's modules pull in its server's libraries (IPython, zmq), so that the import waits until a page is made.
    import umsgpack
    from meshcat.commands import SetObject
    from meshcat.geometry import Mesh, MeshPhongMaterial
    from meshcat.path import Path

    reach = float(np.abs(mesh.vertices).max(initial=1e-9))
    material = MeshPhongMaterial(color=0xFFFFFF, vertexColors=True, reflectivity=0.3, shininess=28, specular=0x2A2A2A)
    if opacity < 1.0:
        material.opacity, material.transparent = opacity, True
    drawn = Mesh(_Packed(mesh, reach / _STEPS), material)
    drawn.uuid, drawn.geometry.uuid, material.uuid = (
        str(uuid.uuid5(_NAMESPACE, f"{path}#{part}")) for part in ("object", "geometry", "material")
    )
    command = SetObject(drawn, path=Path(tuple(path.split("/"))))
    return base64.b64encode(umsgpack.packb(command.lower())).decode()


class _Packed:
    """A geometry in small integers, as Meshcat's classes see one: a number, a transform of its own, and its data."""

    def __init__(self, mesh: Shaded, step: float) -> None:
        self.uuid = ""
        self.mesh, self.step = mesh, step

    def intrinsic_transform(self) -> npt.NDArray[np.float64]:
        return np.diag([self.step, self.step, self.step, 1.0])

    def lower_in_object(self, data: dict[str, Any]) -> str:
        data.setdefault("geometries", []).append(self._lower())
        return self.uuid

    def _lower(self) -> dict[str, Any]:
        small = len(self.mesh.vertices) <= 0xFFFF
        index = self.mesh.faces.astype(np.uint16 if small else np.uint32)
        return {
            "uuid": self.uuid,
            "type": "BufferGeometry",
            "data": {
                "attributes": {
                    "position": _array("Int16Array", 3, np.rint(self.mesh.vertices / self.step).astype(np.int16)),
                    "normal": _array("Int8Array", 3, self.mesh.normals, normalized=True),
                    "color": _array("Uint8Array", 3, self.mesh.colours, normalized=True),
                },
                "index": _array("Uint16Array" if small else "Uint32Array", 1, index),
            },
        }


def _array(kind: str, size: int, values: npt.NDArray[Any], *, normalized: bool = False) -> dict[str, Any]:
    import umsgpack

    little = values.astype(values.dtype.newbyteorder("<"))
    return {
        "itemSize": size,
        "type": kind,
        "array": umsgpack.Ext(_EXTENSION[kind], little.tobytes()),
        "normalized": normalized,
    }
