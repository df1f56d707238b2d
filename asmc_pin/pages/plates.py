"""Figures with captions, and the frame of a page that holds them: one HTML file, or Markdown with PNG files beside."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING

from asmc_pin.disk.files import write_whole
from asmc_pin.errors import ParameterError
from asmc_pin.pages.figure_style import paper_style
from asmc_pin.viewer.player_page import POLICY, player_scripts, static
from asmc_pin.words.media import for_html, for_markdown

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class Plate:
    """A figure, its file's name and its caption."""

    name: str
    figure: Figure
    caption: str

    def png(self) -> bytes:
        """The figure as PNG; the same figure gives the same bytes."""
        buffer = io.BytesIO()
        with paper_style():
            self.figure.savefig(buffer, format="png", metadata={"Software": None})
        return buffer.getvalue()

    def html(self) -> str:
        """The figure inside the page."""
        data = base64.b64encode(self.png()).decode()
        width = f"--width: {self.figure.get_figwidth():.3g}in"  # on paper; on a screen it is as wide as its pixels
        image = f'<img alt="{for_html(self.caption)}" style="{width}" src="data:image/png;base64,{data}">'
        return f'<figure><div class="paper">{image}</div><figcaption>{for_html(self.caption)}</figcaption></figure>'

    def markdown(self, before: str) -> list[str]:
        """Lines that show the figure's PNG file; `before` stands before its name, from the page's own folder."""
        caption = for_markdown(self.caption)
        return ["", f"![{caption}](<{before}{self.name}.png>)", "", f"*{caption}*"]


def is_html(path: Path) -> bool:
    """Whether a page is to be HTML and not Markdown.

    Raises:
        ParameterError: its name ends in neither.
    """
    if path.suffix.lower() not in (".html", ".md"):
        raise ParameterError("report", f"{path.name} ends in neither .html nor .md; the ending chooses the form")
    return path.suffix.lower() == ".html"


def write_beside(path: Path, plates: Iterable[Plate]) -> None:
    """The figures of a Markdown page, beside it."""
    for plate in plates:
        write_whole(path.with_name(f"{path.stem}_{plate.name}.png"), plate.png())


def page_script() -> str:
    """What every page does besides its figures: hints on wide tables, the legend, and paper."""
    return (files("asmc_pin.pages") / "static" / "report.js").read_text(encoding="utf-8")


def framed(title: str, body: list[str], *, player: bool) -> str:
    """A whole HTML page.

    Args:
        title: Plain text.
        body: HTML.
        player: Whether the page shows arms that can be turned.
    """
    own = (files("asmc_pin.pages") / "static").joinpath
    return Template(own("report.html").read_text(encoding="utf-8")).substitute(
        policy=POLICY,
        title=for_html(title),
        style=static("player.css") + own("report.css").read_text(encoding="utf-8"),
        body="\n".join(body),
        scripts="\n".join([*([player_scripts()] if player else []), f"<script>{page_script()}</script>"]),
    )
