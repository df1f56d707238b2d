"""One command in a process of its own, with a limit on its time and its memory."""

from __future__ import annotations

import faulthandler
import os
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

SECONDS = 60
"""Processor time of one command after which it counts as hanging; as much wall time again ten times over."""
MEMORY = 3 << 30
"""Bytes that one command may take on top of what the loaded package has."""


@dataclass(frozen=True)
class Outcome:
    """What a command did.

    Attributes:
        status: Exit status; None where a signal ended it.
        signal: Number of that signal.
        out: Standard output.
        err: Standard error.
        trace: Traceback of an exception that came out of `main`, or of where it hung; empty without.
        seconds: Processor time.
        claims: What `after` had to say of it.
    """

    status: int | None
    signal: int
    out: bytes
    err: bytes
    trace: str
    seconds: float
    claims: list[str]


def command(
    words: list[str],
    scratch: Path,
    before: Callable[[], None] | None = None,
    after: Callable[[int, str], list[str]] | None = None,
) -> Outcome:
    """Run ``asmc-pin`` with these words in a fork of this process.

    Args:
        words: Arguments.
        scratch: Folder with a folder ``work``, which becomes the working directory.
        before: Called in the fork within the limits; what it raises counts as the command's.
        after: Called in the fork with the status and the standard output; what it returns becomes `claims`.
    """
    files = {what: scratch / what for what in ("out", "err", "trace", "claims")}
    sys.stdout.flush()
    sys.stderr.flush()
    child = os.fork()
    if child == 0:
        try:
            _work(words, scratch, files, before, after)
        finally:
            os._exit(99)
    code, used = _wait(child)
    read = {what: path.read_bytes() if path.exists() else b"" for what, path in files.items()}
    return Outcome(
        status=os.WEXITSTATUS(code) if os.WIFEXITED(code) else None,
        signal=os.WTERMSIG(code) if os.WIFSIGNALED(code) else 0,
        out=read["out"],
        err=read["err"],
        trace=read["trace"].decode(errors="replace"),
        seconds=used.ru_utime + used.ru_stime,
        claims=read["claims"].decode(errors="replace").splitlines(),
    )


def _wait(child: int) -> tuple[int, resource.struct_rusage]:
    end, pause = time.monotonic() + 10 * SECONDS, 1e-3
    while True:
        done, code, used = os.wait4(child, os.WNOHANG)
        if done:
            return code, used
        if time.monotonic() > end:
            os.kill(child, signal.SIGKILL)
            _, code, used = os.wait4(child, 0)
            return code, used
        time.sleep(pause)
        pause = min(2.0 * pause, 0.02)


def _work(
    words: list[str],
    scratch: Path,
    files: dict[str, Path],
    before: Callable[[], None] | None,
    after: Callable[[int, str], list[str]] | None,
) -> None:
    (scratch / "tmp").mkdir(exist_ok=True)
    tempfile.tempdir = os.environ["TMPDIR"] = str(scratch / "tmp")
    os.chdir(scratch / "work")
    trace = files["trace"].open("w", encoding="utf-8", errors="backslashreplace")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    for number, what in ((1, "out"), (2, "err")):
        os.dup2(os.open(files[what], os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), number)
    sys.stdout = open(1, "w", encoding="utf-8", errors="strict", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", encoding="utf-8", errors="backslashreplace", closefd=False)  # noqa: SIM115
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 5))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if (pages := _pages()) is not None:
        resource.setrlimit(resource.RLIMIT_AS, (pages + MEMORY, resource.RLIM_INFINITY))
    faulthandler.enable(file=trace, all_threads=False)
    faulthandler.register(signal.SIGXCPU, file=trace, all_threads=False, chain=True)
    from asmc_pin.cli import main

    status: object = 0
    try:
        if before is not None:
            before()
        main(words)
    except SystemExit as end:
        status = end.code
    except BaseException:
        traceback.print_exc(file=trace)
        status = 1
    code = status if isinstance(status, int) else 0 if status is None else 1
    sys.stdout.flush()
    sys.stderr.flush()
    if after is not None:
        try:
            said = after(code, files["out"].read_text(encoding="utf-8"))
        except Exception as error:
            said = [f"judging it failed: {type(error).__name__}: {error}"]
        files["claims"].write_text("\n".join(line.replace("\n", " ") for line in said), encoding="utf-8")
    trace.flush()
    os._exit(code & 0xFF)


def _pages() -> int | None:
    """Bytes of address space that this process has; None where the system does not say."""
    try:
        return int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    except OSError:
        return None
