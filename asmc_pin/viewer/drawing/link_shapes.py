"""Points of what a URDF shows of its links, for who asks whether a number can belong to such a shape."""

from __future__ import annotations

from asmc_pin._typing import Array
from asmc_pin.arms.sources.robot_files import RobotFiles
from asmc_pin.viewer.drawing.surface import join
from asmc_pin.viewer.drawing.visuals import read_visuals


def link_shapes(urdf_text: str, files: RobotFiles) -> tuple[dict[str, Array], dict[str, list[str]]]:
    """Corners of the triangles of every link that shows something.

    Args:
        urdf_text: The URDF.
        files: Where meshes are looked for.

    Returns:
        Points in the link's frame by link, each (n, 3), m; and what could not be read, by link.
    """
    shown, problems = read_visuals(urdf_text, files)
    return {name: join(surfaces).vertices for name, surfaces in shown.items()}, problems
