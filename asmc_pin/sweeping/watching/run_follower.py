"""Following what is being computed: how far a sweep is, and a comparison's replay as soon as it is whole."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from asmc_pin.results.result_folder import EXPERIMENT, TRAJECTORIES, load_result
from asmc_pin.sweeping.row_files import ROWS, SHARDS, shards_there
from asmc_pin.viewer.local_server import serve_page
from asmc_pin.viewer.player_page import POLICY
from asmc_pin.viewer.result_replay import replay_html
from asmc_pin.words.media import for_html

EVERY = 2
"""s between two looks."""


def follow(directory: str | Path, port: int = 0) -> None:
    """Serve a page that follows a running comparison or sweep, until Ctrl-C is pressed.

    It looks again every two seconds: a sweep's trials are counted as their blocks are written; a comparison appears as
    a whole when it is done, and is replayed then.

    Args:
        directory: Folder of the result, which need not be there yet; or its name in ``results/``.
        port: On 127.0.0.1; 0 takes a free one.

    Raises:
        ParameterError: The port is taken.
    """
    serve_page(lambda: followed_page(directory), port, what="following")


def followed_page(directory: str | Path) -> str:
    """What there is to see of a result now."""
    folder = Path(directory)
    if not folder.exists() and (Path("results") / folder).is_dir():
        folder = Path("results") / folder
    if (folder / TRAJECTORIES).is_file():
        return replay_html(load_result(folder))
    if (folder / SHARDS).is_dir():
        return _page(str(directory), _counted(folder), ended=(folder / ROWS).is_file())
    waiting = "started, and nothing is written yet" if (folder / EXPERIMENT).is_file() else "not there yet"
    return _page(str(directory), f"<p>{for_html(str(directory))} is {waiting}.</p>", ended=False)


def _counted(folder: Path) -> str:
    """Trials written so far by controller, and how many of them failed."""
    done: dict[str, int] = {}
    failed: dict[str, int] = {}
    for path in shards_there(folder):
        try:
            table = pq.read_table(path, columns=["controller", "trial", "status"], use_threads=False).to_pandas()
        except (OSError, ValueError, pa.ArrowException):
            continue  # being replaced, or damaged: the sweep itself says so
        for label, rows in table.drop_duplicates(["controller", "trial"]).groupby("controller", sort=False):
            done[str(label)] = done.get(str(label), 0) + len(rows)
            failed[str(label)] = failed.get(str(label), 0) + int((rows.status != "ok").sum())
    rows = "".join(
        f"<tr><th scope='row'>{for_html(label)}</th><td>{count}</td><td>{failed[label]}</td></tr>"
        for label, count in done.items()
    )
    head = "<tr><th scope='col'>controller</th><th scope='col'>trials written</th><th scope='col'>failed</th></tr>"
    return f"<table><thead>{head}</thead><tbody>{rows}</tbody></table>"


def _page(name: str, body: str, *, ended: bool) -> str:
    said = "complete: its report.html has the findings" if ended else f"running; looked at again every {EVERY} s"
    script = "" if ended else f"<script>{_script()}</script>"
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}; connect-src \'self\'">'
        f'<title>{for_html(name)}</title><link rel="icon" href="data:,">'
        '<meta name="viewport" content="width=device-width, initial-scale=1"><style>'
        "html { color-scheme: light dark; } body { font: 16px/1.5 system-ui, sans-serif; margin: 2rem; }"
        "body { background: Canvas; color: CanvasText; overflow-wrap: anywhere; }"
        "th, td { padding: 4px 14px; text-align: right; } th:first-child { text-align: left; }</style></head>"
        f'<body><main class="followed" data-every="{EVERY}"{" data-ended=true" * ended}><h1>{for_html(name)}</h1>'
        f'<p class="state" role="status">{said}</p>{body}</main>{script}</body></html>'
    )


@cache
def _script() -> str:
    return (files("asmc_pin.sweeping.watching") / "following.js").read_text(encoding="utf-8")
