"""All scenes of this folder and an index of them, with pictures where Chromium is installed.

python viz/gallery.py [FOLDER]        default: results/gallery
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from html import escape
from pathlib import Path

import every_arm
import shipped_experiments
import under_a_ceiling

from asmc_pin.disk.files import write_whole

INDEX = """<!doctype html>
<html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark"><title>asmc_pin: gallery</title>
<style>
body {{ margin: 32px auto; max-width: 1100px; padding: 0 20px; font: 16px/1.5 system-ui, sans-serif;
  background: Canvas; color: CanvasText; }}
ul {{ display: grid; grid-template-columns: repeat(auto-fill, minmax(300px, 1fr)); gap: 18px; padding: 0; }}
li {{ list-style: none; }}
img {{ display: block; width: 100%; border-radius: 8px; margin-bottom: 6px; }}
</style>
<main><h1>Gallery</h1><ul>
{items}
</ul></main></html>
"""


def picture(page: Path, time: float, width: int = 960, height: int = 640) -> Path | None:
    """Photographs a page at a time of its motion; None without Chromium."""
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None:
        return None
    out = page.with_suffix(".png")
    flags = "--headless --no-sandbox --hide-scrollbars --use-angle=swiftshader --enable-unsafe-swiftshader"
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = [chromium, *flags.split(), f"--user-data-dir={profile}", f"--window-size={width},{height}"]
        command += [
            "--virtual-time-budget=3000",
            f"--screenshot={out.resolve()}",
            f"{page.resolve().as_uri()}#t={time}",
        ]
        subprocess.run(command, check=True, capture_output=True, timeout=120)
    return out


def main(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    pages = {**shipped_experiments.make(folder), **every_arm.make(folder), **under_a_ceiling.make(folder)}
    items = []
    for title, page in pages.items():
        shot = picture(page, time=1.6)
        image = f'<img src="{escape(shot.name)}" alt="" loading="lazy">' if shot else ""
        items.append(f'<li><a href="{escape(page.name)}">{image}{escape(title)}</a></li>')
    index = folder / "index.html"
    write_whole(index, INDEX.format(items="\n".join(items)))
    return index


if __name__ == "__main__":
    print(main(Path(sys.argv[1] if len(sys.argv) > 1 else "results/gallery")))
