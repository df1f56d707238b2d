"""One picture of many arms, each from its own page: the shipped ones, or those whose URDFs are given.

python viz/contact_sheet.py [FILE.png [URDF …]]        default: results/gallery/arms.png, all that ship
"""

from __future__ import annotations

import argparse
import io
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import every_arm
from PIL import Image, ImageDraw, ImageFont

from asmc_pin.arms import Arm, arm_names, load_arm
from asmc_pin.disk.files import write_whole
from asmc_pin.viewer.film.headless_browser import HeadlessPage, headless_page
from asmc_pin.viewer.film.replay_pictures import BARE

FRAME = (480, 400)
"""Pixels of each arm's picture."""


@contextmanager
def photographer(width: int, height: int) -> Iterator[HeadlessPage]:
    """A page in the project's own browser, of that size."""
    with headless_page() as page:
        page.size(width, height)
        yield page


def photograph(page: HeadlessPage, file: Path, time: float, *, bare: bool = False) -> bytes:
    """What a page of the viewer shows at a time, as PNG; `bare`: its scene alone."""
    page.open("about:blank")  # another fragment of the same file alone would not load it anew
    page.open(f"{file.resolve().as_uri()}#t={time:g}")
    if bare:
        page.run(BARE)
    page.run("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return page.picture()


def sheet(arms: Mapping[str, Arm], columns: int = 4) -> Image.Image:
    """All arms in rows, each under its name."""
    names, font, (width, height) = list(arms), ImageFont.load_default(16), FRAME
    made = Image.new("RGB", (columns * width, -(-len(names) // columns) * (height + 24)), "white")
    pen = ImageDraw.Draw(made)
    with tempfile.TemporaryDirectory() as folder, photographer(width, height) as page:
        for k, name in enumerate(names):
            file = Path(folder) / f"{k}.html"
            write_whole(file, every_arm.page(arms[name], name, ""))
            x, y = k % columns * width, k // columns * (height + 24)
            made.paste(Image.open(io.BytesIO(photograph(page, file, 1.6, bare=True))).convert("RGB"), (x, y + 24))
            pen.text((x + 8, y + 3), name, fill="black", font=font)
    return made


def main(out: Path, urdfs: list[str]) -> Path:
    arms = {Path(source).stem: load_arm(source) for source in urdfs or arm_names()}
    picture = io.BytesIO()
    sheet(arms).save(picture, "png")
    write_whole(out, picture.getvalue())
    return out


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("file", nargs="?", type=Path, default=Path("results/gallery/arms.png"), help="a PNG")
    parser.add_argument("urdfs", nargs="*", metavar="URDF", help="arms, or URDFs; all that ship by default")
    options = parser.parse_args()
    if options.file.suffix.lower() != ".png":
        parser.error(f"{options.file} does not end in .png")
    options.file.parent.mkdir(parents=True, exist_ok=True)
    print(main(options.file, options.urdfs))
