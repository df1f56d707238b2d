"""What a person reads and watches: results on standard output, remarks and progress on standard error."""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from asmc_pin.words.text import printable, visible

if TYPE_CHECKING:
    from rich.console import Console


def say(*lines: str) -> None:
    """Lines of a result, on standard output; a name brings no line break and no control character into them."""
    print("\n".join(map(visible, lines)))


def note(message: str) -> None:
    """A remark on standard error, where it never mixes with a result; the lines of a list stay lines."""
    print("asmc-pin: " + "\n  ".join(map(visible, message.split("\n  "))), file=sys.stderr)


def announce_compiling() -> None:
    """From here on, say so where the wait is for the compiler; loads what is to be compiled."""
    from asmc_pin.clock import tell_of_compiling

    tell_of_compiling(lambda: note("compiling for this machine, once; a first run takes up to a minute longer"))


def rich_console(*, stderr: bool = False) -> Console:
    """A console that prints text as it is: what stands in square brackets or between colons is no markup here."""
    from rich.console import Console

    return Console(stderr=stderr, markup=False, emoji=False, highlight=False)


@contextmanager
def progress_bar(*, lines_every: float = math.inf, of: str = "of the time") -> Iterator[Callable[[str, float], None]]:
    """A bar on standard error; where that is no terminal, a line now and then, or nothing.

    Args:
        lines_every: Least time between two such lines, s.
        of: What the share in such a line is of.

    Yields:
        A function of what is being done, and which share of all is done, 0 to 1.
    """
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

    console = rich_console(stderr=True)
    if not console.is_terminal:
        told = time.monotonic()

        def line(what: str, share: float) -> None:
            nonlocal told
            if time.monotonic() - told >= lines_every:
                told = time.monotonic()
                note(f"{what} ({min(share, 1.0):.0%} {of})")

        yield line
        return
    columns = (
        TextColumn("{task.description:<12}", markup=False),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("", total=1.0)
        yield lambda what, share: bar.update(task, description=printable(what), completed=share)


def print_json(value: dict[str, Any]) -> None:
    """Print one strictly valid JSON object: undefined figures become null."""
    from asmc_pin.cli.output import is_unicode

    text = json.dumps(_plain(value), ensure_ascii=not is_unicode(), allow_nan=False, indent=2)
    # A reader of JSON gets every name as it is, and a terminal no character that steers it.
    print("".join(c if c.isascii() or visible(c) == c else json.dumps(c)[1:-1] for c in text))


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if hasattr(value, "tolist"):  # NumPy's arrays and numbers, without NumPy
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Path):
        return str(value)
    return value
