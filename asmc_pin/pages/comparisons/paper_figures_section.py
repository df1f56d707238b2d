"""The figures of a comparison as they would stand in a paper, within its page."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from pathlib import Path

from asmc_pin.disk.reading import read_file, shown
from asmc_pin.errors import ResultError
from asmc_pin.pages.comparison_figures import FIGURES
from asmc_pin.pages.theorem_figures import CAPTION as THEOREMS_CAPTION
from asmc_pin.pages.theorem_figures import NAME as THEOREMS
from asmc_pin.results.result_folder import Result
from asmc_pin.words.media import for_html

_MOST_FIGURES, _LARGEST_FIGURE = 50, 20_000_000


def paper_figures(result: Result) -> Iterator[str]:
    """The PNG files of the result's folder, embedded; nothing where it has none."""
    there = {path.stem: path for path in sorted((result.path / "figures").glob("*.png"))}
    if not there:
        return
    if len(there) > _MOST_FIGURES:
        raise ResultError(result.path, f"{result.path}: has {len(there)} figures, at most {_MOST_FIGURES} expected")
    yield '<h2 id="figures">Figures for a paper</h2>'
    yield '<p class="soft">As they lie in <code>figures/</code>, as PDF too.</p><details><summary>Show them</summary>'
    yield '<div class="body">'
    captions = {name: drawing.caption for name, drawing in FIGURES.items()} | {THEOREMS: THEOREMS_CAPTION}
    for name in [*(name for name in captions if name in there), *(name for name in there if name not in captions)]:
        path, caption = there[name], captions.get(name, f"{name.replace('_', ' ').capitalize()}.")
        data = base64.b64encode(_figure(result, path)).decode()
        yield (
            f'<figure><div class="paper"><img alt="{for_html(caption)}" src="data:image/png;base64,{data}"></div>'
            f"<figcaption>{for_html(caption)}</figcaption></figure>"
        )
    yield "</div></details>"


def _figure(result: Result, path: Path) -> bytes:
    """A figure of the result's own: a link out of the folder would put another file into a page that is mailed."""
    if not path.resolve().is_relative_to(result.path.resolve()):
        raise ResultError(result.path, f"{shown(path)}: lies elsewhere; a result's figures are in its folder")
    data = read_file(path, _LARGEST_FIGURE, "a figure", lambda message: ResultError(result.path, message))
    if not data.startswith(b"\x89PNG\r\n"):
        raise ResultError(result.path, f"{shown(path)}: is no PNG file; run the comparison again")
    return data
