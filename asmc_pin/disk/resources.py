"""Where shipped arms, experiments and documentation lie: inside an installed wheel, or at the top of a checkout."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent.parent


def shipped(folder: str) -> Path:
    """Folder of shipped files.

    Args:
        folder: ``"urdf"``, ``"experiments"`` or ``"docs"``.

    Returns:
        The folder inside the installed package, or the checkout's own when there is none.
    """
    installed = _PACKAGE / "_data" / folder
    return installed if installed.is_dir() else _PACKAGE.parent / folder
