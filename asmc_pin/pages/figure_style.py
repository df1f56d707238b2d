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

COLUMN, PAGE = 3.5, 7.16
"""Width of one and of two columns, inch (IEEE)."""

GREY = "#7F7F7F"

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
    "savefig.dpi": 200,
}


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
