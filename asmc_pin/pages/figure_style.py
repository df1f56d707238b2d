"""How figures look: the size and type of a two-column journal, and bands. Colours: `asmc_pin.viewer.colours`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from asmc_pin.pages.curves import envelope, running_max

_POINT = 1.0 / 72.27
COLUMN, PAGE = 252.0 * _POINT, 516.0 * _POINT
"""Width of one and of two columns of a two-column journal (IEEE), inch: a figure of that size needs no scaling."""

_DASHES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (1.2, 1.2)), (0, (6, 1.5, 1.2, 1.5)))
_MARKERS = "os^Dv<>P"

GREY = "#7F7F7F"

_SMALLEST = 5.0
"""Letters of a name, pt."""

BAND = (
    "Lines: the first trial. Shaded, where there are several trials: 5 % to 95 % of them at each tick, "
    "as far as three times the line's largest value."
)
"""For the words below a figure."""

_STYLE: Any = {
    "font.family": "serif",
    "font.serif": ["STIXGeneral"],
    "mathtext.fontset": "stix",
    "font.size": 8.0,
    "axes.titlesize": 8.0,
    "axes.labelsize": 8.0,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "legend.fontsize": 7.5,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "legend.columnspacing": 1.4,
    "lines.linewidth": 0.9,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.titlepad": 3.0,
    "axes.labelpad": 2.0,
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "axes.unicode_minus": True,
    "path.simplify": True,
    "pdf.fonttype": 42,  # TrueType: journals refuse Type 3 fonts
    "pdf.compression": 6,
    "svg.hashsalt": "asmc_pin",
    "savefig.dpi": 160,
}


def line_look(controller: int, color: str, points: int = 0) -> dict[str, Any]:
    """How the line of a controller looks: told from the others by its dashes and its marker on grey paper too.

    Args:
        controller: Its place in the experiment.
        color: Its colour on the screen.
        points: How many points the line has, of which seven carry a marker; 0 for a line in a legend.

    Returns:
        Keywords of `matplotlib.axes.Axes.plot`.
    """
    step = max(1, points // 7)
    # Of nine and more the markers come again, with other dashes.
    dashes = (controller + controller // len(_MARKERS)) % len(_DASHES)
    return {
        "color": color,
        "linestyle": _DASHES[dashes],
        "marker": _MARKERS[controller % len(_MARKERS)],
        "markersize": 2.4 if points else 3.5,
        "markeredgewidth": 0.0,
        "markevery": (controller % 5 * step // 5, step) if points else None,  # those of two lines lie apart
    }


def dot_look(controller: int, color: str) -> dict[str, Any]:
    """The same of a controller's dots."""
    marker = _MARKERS[controller % len(_MARKERS)]
    return {"color": color, "linestyle": "none", "marker": marker, "markersize": 2.6, "markeredgewidth": 0.0}


def fitted(name: str, room: float) -> tuple[str, float]:
    """A name and the size of its letters, pt, with which it takes no more than its room, pt; cut in its middle at last.

    A letter of this type is half as wide as it is high, in the mean.
    """
    size = min(8.0, 2.0 * room / max(1, len(name)))
    if size >= _SMALLEST:
        return name, size
    kept = max(2, int(2.0 * room / _SMALLEST)) - 1
    return f"{name[: -(-kept // 2)]}…{name[len(name) - kept // 2 :]}", _SMALLEST


def folded(name: str) -> str:
    """A long name in two lines, broken after the underscore that is nearest to its middle."""
    breaks = [at + 1 for at, letter in enumerate(name) if letter == "_"]
    if len(name) <= 14 or not breaks:
        return name
    at = min(breaks, key=lambda place: abs(place - len(name) / 2))
    return f"{name[:at]}\n{name[at:]}"


@contextmanager
def paper_style() -> Iterator[None]:
    """Matplotlib's settings for the figures, whatever the user's own are."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_STYLE)
        yield


def save(figure: Figure, path: Path) -> None:
    """Write PATH.pdf and PATH.png without dates and versions, so that the same figure gives the same bytes."""
    figure.draw_without_rendering()  # one layout serves both
    figure.set_layout_engine(None)
    undated = {"CreationDate": None, "Creator": None, "Producer": None}
    figure.savefig(path.with_suffix(".pdf"), metadata=undated)
    figure.savefig(path.with_suffix(".png"), metadata={"Software": None})


def shade(axis: Axes, run: xr.Dataset, name: str, joint: int, factor: float, color: str) -> None:
    """Shade where nine of ten trials of a signal lie at each tick; nothing of a single trial.

    Called after the line of the first trial, at three times whose largest value the band is cut: a trial that is about
    to diverge would flatten all else.

    Args:
        axis: Where to.
        run: Of one controller, with the bands of its trials where there are such.
        name: Of the signal.
        joint: Which joint.
        factor: From SI to the unit of the axis.
        color: That of the line.
    """
    if f"{name}_low" in run:
        most = 3.0 * np.nanmax(np.abs(np.asarray(axis.lines[-1].get_ydata(), dtype=np.float64)), initial=0.0)
        ends = (factor * run[f"{name}_{end}"].to_numpy()[:, joint] for end in ("low", "high"))
        low, high = (np.clip(end, -most, most) for end in ends)
        axis.fill_between(*envelope(run.time.to_numpy(), low, high), color=color, alpha=0.25, linewidth=0.0)


def shade_sizes(axis: Axes, run: xr.Dataset, joint: int, factor: float, color: str) -> None:
    """The same of the largest error in each window, as `running_max` draws it."""
    if "error_size_low" in run:
        time, ends = run.time.to_numpy(), ("low", "high")
        sizes = [factor * run[f"error_size_{end}"].to_numpy()[:, joint] for end in ends]
        (middle, low), (_, high) = (running_max(time, size) for size in sizes)
        axis.fill_between(middle, low, high, color=color, alpha=0.25, linewidth=0.0)
