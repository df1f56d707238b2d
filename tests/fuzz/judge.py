"""What must hold of every command, whatever it was given."""

from __future__ import annotations

import json
import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fuzz.hostile import INJECTED
from fuzz.run import Outcome

STATUSES = {0, 1, 2, 3, 130}
LONGEST = 4000
"""Characters of one message: it says what and how to correct it, and may list several mistakes."""

_FRAME = re.compile(r'File "[^"]*/(asmc_pin/[^"]+)", line (\d+)[^\n]*?in (\S+)')
_ANY_FRAME = re.compile(r'File "([^"]+)", line (\d+)[^\n]*?in (\S+)')
_FORMAT = {"\u200c", "\u200d"}  # joiners that scripts and emoji need


@dataclass(frozen=True)
class Fault:
    """One thing that did not hold.

    Attributes:
        what: Which.
        where: The place in the code, or the like, by which faults of one cause are told to be one.
        detail: What was seen.
    """

    what: str
    where: str
    detail: str


def faults(words: list[str], outcome: Outcome, scratch: Path) -> Iterator[Fault]:
    """All that did not hold.

    Args:
        words: The command.
        outcome: What it did.
        scratch: Its folder, with ``work`` and ``tmp`` in it.
    """
    command = words[0]
    out = outcome.out.decode("utf-8", errors="surrogateescape")
    err = outcome.err.decode("utf-8", errors="surrogateescape")
    trace = outcome.trace or _left(err, scratch)
    if outcome.status is None:
        what = "hangs" if outcome.signal in (9, 24) else f"killed by signal {outcome.signal}"
        yield Fault(what, place(trace) or command, f"after {outcome.seconds:.0f} s of processor time\n{short(trace)}")
        return
    if outcome.status not in STATUSES:
        yield Fault(f"status {outcome.status}", _raised(trace), short(trace) or err[-1500:])
    elif trace:
        yield Fault("an exception came out of main", _raised(trace), short(trace))
    if "Traceback (most recent call last)" in err:
        yield Fault("traceback on standard error", _raised(err), short(err))
    yield from _messages(command, outcome.status, out, err)
    yield from _characters(command, out, err)
    if outcome.status in (0, 1, 3) and "--json" in words and not trace:
        yield from _json(command, out)
    yield from _files(command, scratch)
    for claim in outcome.claims:
        yield Fault("false claim", claim.split(":", 1)[0], claim)


def place(trace: str) -> str:
    """File and function of the innermost frame in this package, without the line, which moves."""
    frames = _FRAME.findall(trace)
    if not frames:
        return ""
    # faulthandler has the innermost first, and says so.
    file, _, function = frames[0] if "most recent call first" in trace else frames[-1]
    return f"{file}:{function}"


def short(trace: str) -> str:
    """The frames of this package, the innermost of all, and what was raised."""
    lines = trace.strip().splitlines()
    frames = [line.strip() for line in lines if line.lstrip().startswith("File ")]
    ours = [line for line in frames if "/asmc_pin/" in line]
    inner = [] if not frames or frames[-1] in ours else [frames[-1]]
    raised = [line for line in lines if line and not line.startswith((" ", "Traceback"))][-1:]
    return "\n".join([*ours[-8:], *inner, *raised])[-2500:]


def _raised(trace: str) -> str:
    lines = [line for line in trace.strip().splitlines() if line and not line.startswith(" ")]
    kind = lines[-1].split(":", 1)[0] if lines else "?"
    inner = _ANY_FRAME.findall(trace)
    library = f" (in {Path(inner[-1][0]).name}:{inner[-1][2]})" if inner and "asmc_pin" not in inner[-1][0] else ""
    return f"{kind} at {place(trace)}{library}"


def _left(err: str, scratch: Path) -> str:
    """The traceback that a fault of ours left in a file, which the message names."""
    for path in sorted((scratch / "tmp").rglob("*")):
        if path.is_file() and path.name in err:
            text = path.read_text(encoding="utf-8", errors="replace")
            if "Traceback" in text:
                return text
    return ""


def _messages(command: str, status: int, out: str, err: str) -> Iterator[Fault]:
    """Standard error has messages of this tool alone; a refusal is one of them, and nothing else is said."""
    first, *said = re.split(r"^asmc-pin: ", err, flags=re.MULTILINE)
    if first.strip():
        yield Fault("a stranger's words on standard error", f"{command}: {first.strip()[:60]}", err[:600])
    refusals = [text for text in said if not text.startswith(("warning: ", "compiling "))]
    if status == 2:
        if out:
            yield Fault("status 2 with standard output", command, out[:300])
        if len(refusals) != 1:
            yield Fault("status 2 with other than one message", command, err[:600])
        elif not refusals[0].strip():
            yield Fault("an empty message", command, err[:300])
    if status == 2 and any(text.startswith("out of memory") for text in refusals):
        yield Fault("out of memory", command, err[:600])
    for text in said:
        if len(text) > LONGEST:
            yield Fault("a message without end", f"{command}: {text[:40]}", f"{len(text)} characters: {text[:300]}")
        if text.startswith("warning: ") and re.search(r"encountered in |\w+Warning|deprecated", text):
            yield Fault("a library's warning", f"{command}: {text[9:70]}", text[:400])


def _characters(command: str, out: str, err: str) -> Iterator[Fault]:
    for what, text in (("standard output", out), ("standard error", err)):
        if bad := unprintable(text):
            at = text.index(bad)
            yield Fault(f"a control character on {what}", command, repr(text[max(0, at - 80) : at + 40]))


def unprintable(text: str) -> str:
    """The first character that a terminal may obey or that turns the reading; empty without one."""
    for c in text:
        if c not in "\n\t" and c not in _FORMAT and (unicodedata.category(c) in ("Cc", "Cf", "Cs", "Zl", "Zp")):
            return c
    return ""


def _json(command: str, out: str) -> Iterator[Fault]:
    def pairs(items: list[tuple[str, Any]]) -> dict[str, Any]:
        made = dict(items)
        if len(made) != len(items):
            raise ValueError("a key stands twice")
        return made

    def constant(text: str) -> None:
        raise ValueError(f"{text} is not JSON")

    try:
        said = json.loads(out, object_pairs_hook=pairs, parse_constant=constant)
    except ValueError as error:
        yield Fault("not one valid JSON object", f"{command}: {str(error)[:60]}", out[:600])
        return
    if not isinstance(said, dict):
        yield Fault("not one valid JSON object", command, out[:300])
        return
    waiting: list[Any] = [said]
    while waiting:
        at = waiting.pop()
        if isinstance(at, dict):
            waiting += [*at, *at.values()]
        elif isinstance(at, list):
            waiting += at
        elif isinstance(at, str) and (bad := unprintable(at)):
            yield Fault("a control character in JSON", command, repr(at[:200]) + f" has {bad!r}")
            return


def _files(command: str, scratch: Path) -> Iterator[Fault]:
    work = scratch / "work"
    for path in work.rglob("*"):
        if re.search(r"\.(new|old|part|tmp)$|^\.", path.name):
            yield Fault("left behind", f"{command}: {path.suffix or path.name}", str(path.relative_to(work)))
        elif path.suffix == ".html" and INJECTED in path.read_text(encoding="utf-8", errors="replace"):
            yield Fault("markup in a page", command, str(path.relative_to(work)))
    # To compare is to run the laws that a file names; to look at a result is not.
    if command != "compare" and (work / "imported").exists():
        yield Fault("a stranger's code was imported", command, "the canary of the experiment's folder ran")
