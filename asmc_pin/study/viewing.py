"""Looking at a result: a replay in the browser, or a page that can be mailed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from asmc_pin.disk.file_access import check_writable
from asmc_pin.disk.files import write_whole
from asmc_pin.results.result_folder import Result, find_result, load_result
from asmc_pin.study.comparison import Comparison


def view(
    result: Result | Comparison | str | Path,
    *,
    html: str | Path | None = None,
    png: str | Path | None = None,
    time: float = 0.0,
    mp4: str | Path | None = None,
    progress: Callable[[float], None] | None = None,
    port: int = 0,
    open_browser: bool = False,
) -> Path | None:
    """Replay a result: the controllers side by side, each with the reference as a translucent arm.

    Args:
        result: A result or a comparison; or the folder of one, or its name in ``results/``.
        html: Write a page that opens offline to this file, and serve nothing.
        png: Write what is to be seen at a time to this file, by a headless Chromium, and serve nothing.
        time: Of `png`, s.
        mp4: Write a film of all of it to this file likewise.
        progress: Of `mp4`: called with the share that is done.
        port: Without a file: of the server on 127.0.0.1, which no other machine reaches; 0 takes a free one.
        open_browser: Without a file: open the page in the user's browser as well.

    Returns:
        The last file that was written; None after serving, which lasts until Ctrl-C is pressed.

    Raises:
        ResultError: The folder is no result, its arm cannot be drawn, or the page cannot be written.
        ParameterError: The port is taken, there is no browser for pictures, or nothing moves at that time.
        MissingDependencyError: A package of the extra ``film`` is not installed.
    """
    from asmc_pin import viewer

    files = [Path(file) for file in (html, png, mp4) if file is not None]
    if not files:
        viewer.serve(_folder(result), port, open_browser=open_browser)
        return None
    for file in files:
        check_writable(file)  # before a long result is read
    page = viewer.replay_html(result if isinstance(result, Result) else load_result(_folder(result)))
    if html is not None:
        write_whole(html, page)
    if png is not None:
        from asmc_pin.viewer.film.replay_pictures import take_still

        take_still(page, png, time)
    if mp4 is not None:
        from asmc_pin.viewer.film.replay_pictures import take_film

        take_film(page, mp4, progress=progress)
    return files[-1]


def _folder(result: Result | Comparison | str | Path) -> Path:
    if isinstance(result, Result):
        return result.path
    return find_result(result.out if isinstance(result, Comparison) else result)
