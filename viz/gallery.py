"""All scenes of this folder and an index of them, with pictures where Chromium is installed.

python viz/gallery.py [FOLDER]        default: results/gallery
"""

from __future__ import annotations

from contextlib import nullcontext
from html import escape
from pathlib import Path

import every_arm
import shipped_experiments
import under_a_ceiling
from asked import asked_folder
from contact_sheet import photograph, photographer

from asmc_pin.disk.files import write_whole
from asmc_pin.errors import ParameterError
from asmc_pin.viewer.film.headless_browser import browser_program

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


def main(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    pages = {**shipped_experiments.make(folder), **every_arm.make(folder), **under_a_ceiling.make(folder)}
    items = []
    with photographer(960, 640) if has_browser() else nullcontext() as browser:
        for title, page in pages.items():
            image = ""
            if browser is not None:
                shot = page.with_suffix(".png")
                write_whole(shot, photograph(browser, page, 1.6))
                image = f'<img src="{escape(shot.name)}" alt="" loading="lazy">'
            items.append(f'<li><a href="{escape(page.name)}">{image}{escape(title)}</a></li>')
    index = folder / "index.html"
    write_whole(index, INDEX.format(items="\n".join(items)))
    return index


def has_browser() -> bool:
    """Whether there is a Chromium to take pictures with."""
    try:
        browser_program()
    except ParameterError:
        return False
    return True


if __name__ == "__main__":
    print(main(asked_folder(__doc__)[0]))
