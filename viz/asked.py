"""Where a scene of this folder goes, as it is asked for on the command line."""

from __future__ import annotations

import argparse
from pathlib import Path


def asked_folder(about: str, *, names: str = "") -> tuple[Path, list[str]]:
    """The folder that is named, made if need be, and the names after it.

    Args:
        about: The script's docstring, of which help shows the first line.
        names: What further words name; none are taken where it is empty.
    """
    parser = argparse.ArgumentParser(description=about.partition("\n")[0])
    parser.add_argument("folder", nargs="?", type=Path, default=Path("results/gallery"), help="default: %(default)s")
    if names:
        parser.add_argument("names", nargs="*", help=names)
    options = parser.parse_args()
    if options.folder.exists() and not options.folder.is_dir():
        parser.error(f"{options.folder} is not a folder")
    options.folder.mkdir(parents=True, exist_ok=True)
    return options.folder, options.names if names else []
