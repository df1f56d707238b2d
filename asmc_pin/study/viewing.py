"""Looking at a result: a replay in the browser, or a page that can be mailed."""

from __future__ import annotations

from pathlib import Path

from asmc_pin.disk.files import check_writable
from asmc_pin.results.result_folder import Result, find_result, load_result
from asmc_pin.study.comparison import Comparison


def view(
    result: Result | Comparison | str | Path,
    *,
    html: str | Path | None = None,
    port: int = 0,
    open_browser: bool = False,
) -> Path | None:
    """Replay a result: the controllers side by side, each with the reference as a translucent arm.

    Args:
        result: A result or a comparison; or the folder of one, or its name in ``results/``.
        html: Write a page that opens offline to this file, and serve nothing.
        port: Without `html`: of the server on 127.0.0.1, which no other machine reaches; 0 takes a free one.
        open_browser: Without `html`: open the page in the user's browser as well.

    Returns:
        The page that was written; None after serving, which lasts until Ctrl-C is pressed.

    Raises:
        ResultError: The folder is no result, its arm cannot be drawn, or the page cannot be written.
        ParameterError: The port is taken.
    """
    from asmc_pin import viewer

    if html is None:
        viewer.serve(_folder(result), port, open_browser=open_browser)
        return None
    page = Path(html)
    check_writable(page)  # before a long result is read
    viewer.write_replay(result if isinstance(result, Result) else load_result(_folder(result)), page)
    return page


def _folder(result: Result | Comparison | str | Path) -> Path:
    if isinstance(result, Result):
        return result.path
    return find_result(result.out if isinstance(result, Comparison) else result)
