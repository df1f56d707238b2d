"""The element that the interactive figures fill, and the scripts that a page with it needs once."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

from asmc_pin.errors import MissingDependencyError
from asmc_pin.pages.interactive.signal_curves import described
from asmc_pin.pages.tables.text_table import number
from asmc_pin.results.kept_ticks import keeps_the_end, of_kept_ticks
from asmc_pin.results.result_folder import Result
from asmc_pin.viewer import controller_colors
from asmc_pin.viewer.player_page import inert, json_text
from asmc_pin.words.media import for_html

_BUNDLES = ("bokeh.min.js", "bokeh-api.min.js")


def figure_element(result: Result, short: list[str]) -> str:
    """The controls, the place of the plots, and the data of a result; `figure_scripts` fills it.

    Args:
        result: The result.
        short: The joints' names as tables show them.
    """
    dataset = result.dataset
    labels = [str(label) for label in dataset.controller.to_numpy()]
    colours = controller_colors(labels)
    kept = result.experiment.log_every
    ended = keeps_the_end(len(result.experiment.time), kept)
    data = described(dataset, result.monitors, ended) | {
        "controllers": [{"label": label, "colour": colours[label]} for label in labels],
        "joints": short,
        "duration": float(dataset.time[-1]),
        "kept": of_kept_ticks(kept),
    }
    every = data["every"]
    span = number(1e3 * every * kept * result.experiment.period)
    several = ". Shaded: 5 % to 95 % of all trials" if any(item["bands"] for item in data["signals"]) else ""
    drawn = (
        f"from the lowest and the highest value of every {every} ticks ({span} ms)" if every > 1 else "from every tick"
    )
    if kept > 1:
        drawn = f"{drawn.replace('tick', 'kept tick')}; one tick in {kept} is kept, and what is between does not show"
    caption = (
        f"Curves of the first trial over time in s, drawn {drawn}{several}. Logarithmic axes show sizes. After a click "
        "the wheel zooms; a click also takes the scene to that time."
    )
    return (
        '<div class="signals"><div class="signals-controls" role="group" aria-label="What the figures show"></div>'
        '<div class="signals-plots"></div>'
        f'<p class="soft signals-caption">{for_html(caption)}</p>'
        '<p class="soft signals-words" aria-live="polite"></p>'
        f'<script type="application/json">{json_text(data)}</script></div>'
    )


@cache
def figure_scripts() -> str:
    """BokehJS, which begins with its licence, and what draws with it, as script elements.

    Raises:
        MissingDependencyError: Bokeh is not installed.
    """
    found = find_spec("bokeh")
    if found is None or not found.submodule_search_locations:
        raise MissingDependencyError("bokeh", "", "interactive figures in a report")
    package = Path(found.submodule_search_locations[0])
    bundles = [(package / "server" / "static" / "js" / name).read_text(encoding="utf-8") for name in _BUNDLES]
    own = [(files("asmc_pin.pages.interactive") / "static" / "signals.js").read_text(encoding="utf-8")]
    return "\n".join(f"<script>{inert(script)}</script>" for script in [*bundles, *own])
