"""Thousands of inputs on several processes, and a report of what did not hold."""

from __future__ import annotations

import argparse
import functools
import importlib
import multiprocessing
import shlex
import shutil
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fuzz import corpus, generate_toml, generate_urdf, mutate_certificate, mutate_result, truth
from fuzz.judge import Fault, faults
from fuzz.run import command

MAKERS: dict[str, Callable[..., list[str]]] = {
    "urdf": generate_urdf.make,
    "toml": generate_toml.make,
    "certificate": mutate_certificate.make,
    "result": mutate_result.make,
}
DRAWN = 10
"""One comparison in so many also writes its trajectories and tables, and draws: that takes most of the time."""


@dataclass(frozen=True)
class Tried:
    """One input and what came of it."""

    kind: str
    index: int
    words: list[str]
    status: int | None
    seconds: float
    faults: list[Fault]


WRITING = (
    ("asmc_pin.study.comparison_files", "draw_figures"),
    ("asmc_pin.study.comparison_files", "summary_markdown"),
    ("asmc_pin.study.run_monitors", "draw_theorems"),
    ("asmc_pin.pages.comparison_page", "report_html"),
    ("asmc_pin.results.result_folder", "load_result"),
    ("asmc_pin.results.result_writing", "write_trajectories"),
)
"""What writes and draws of a comparison, or reads what is to be drawn, and the module where it is looked up."""


def unwritten() -> None:
    """Compare, and write no more than the summary, the figures in JSON and what the monitors say."""
    for module, what in WRITING:
        assert hasattr(importlib.import_module(module), what)
        setattr(sys.modules[module], what, lambda *_, **__: "")


def trial(kind: str, seed: int, index: int, sound: Any, scratch: Path) -> Tried:
    """Make one input in a folder, run its command, judge it."""
    rng = np.random.default_rng([seed, sorted(MAKERS).index(kind), index])
    work = scratch / "work"
    work.mkdir(parents=True)
    usual = sys.getrecursionlimit()
    sys.setrecursionlimit(20_000)  # what is to be too deep for a reader must be made first
    try:
        words = MAKERS[kind](rng, work, sound)
    except Exception as error:
        detail = "".join(traceback.format_exception(error))
        return Tried(kind, index, [], None, 0.0, [Fault("no input was made", type(error).__name__, detail)])
    finally:
        sys.setrecursionlimit(usual)
    after = None
    if kind == "certificate" and "--json" in words:
        after = functools.partial(truth.judge, work / "x.cert")
    before = unwritten if words[0] == "compare" and index % DRAWN else None
    outcome = command(words, scratch, before, after)
    return Tried(kind, index, words, outcome.status, outcome.seconds, list(faults(words, outcome, scratch)))


def _job(seed: int, sounds: dict[str, Any], job: tuple[str, int]) -> Tried:
    with tempfile.TemporaryDirectory(prefix="fuzz-", ignore_cleanup_errors=True) as scratch:
        return trial(job[0], seed, job[1], sounds[job[0]], Path(scratch))


def report(tried: list[Tried], seed: int) -> bool:
    """Print statuses and faults, those of one cause together; whether all held."""
    causes: dict[tuple[str, str], list[tuple[Tried, Fault]]] = {}
    for kind in dict.fromkeys(t.kind for t in tried):
        mine = [t for t in tried if t.kind == kind]
        statuses = Counter("signal" if t.status is None else str(t.status) for t in mine)
        each = ", ".join(f"{status}: {count}" for status, count in sorted(statuses.items()))
        slowest = max(mine, key=lambda t: t.seconds)
        print(f"{kind}: {len(mine)} inputs; status {each}; slowest {slowest.seconds:.1f} s (--index {slowest.index})")
        for t in mine:
            for fault in t.faults:
                causes.setdefault((fault.what, fault.where), []).append((t, fault))
    for (what, where), found in sorted(causes.items(), key=lambda item: -len(item[1])):
        first, fault = min(found, key=lambda pair: (pair[0].kind, pair[0].index))
        print(f"\n=== {what}: {where}  ({len(found)} times)")
        print(f"    again: python -m fuzz --kind {first.kind} --seed {seed} --index {first.index} --keep DIR")
        print(f"    asmc-pin {shlex.join(first.words)}".encode("utf-8", "backslashreplace").decode())
        print("    " + fault.detail.encode("utf-8", "backslashreplace").decode().replace("\n", "\n    "))
    print(f"\n{len(causes)} kinds of faults")
    return not causes


def main() -> None:
    """The command line of ``python -m fuzz``; status 1 where something did not hold."""
    parser = argparse.ArgumentParser(prog="python -m fuzz", description=__doc__)
    parser.add_argument("--kind", action="append", choices=sorted(MAKERS), help="one kind of input; repeatable")
    parser.add_argument("--count", type=int, default=100, help="inputs of each kind")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--start", type=int, default=0, help="first index")
    parser.add_argument("--index", type=int, help="this input alone")
    parser.add_argument("--keep", type=Path, help="with --index: leave the input and what it gave in this folder")
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    kinds = asked.kind or list(MAKERS)
    with tempfile.TemporaryDirectory(prefix="fuzz-corpus-") as folder:
        sounds = {kind: corpus.make(kind, Path(folder)) for kind in kinds}
        if asked.index is not None:
            kept = asked.keep or Path(folder) / "one"
            if kept.exists():
                shutil.rmtree(kept)
            tried = [trial(kind, asked.seed, asked.index, sounds[kind], kept.resolve()) for kind in kinds]
        else:
            jobs = [(kind, k) for kind in kinds for k in range(asked.start, asked.start + asked.count)]
            context = multiprocessing.get_context("fork")
            with context.Pool(asked.workers) as pool:
                one = functools.partial(_job, asked.seed, sounds)
                tried = list(pool.imap_unordered(one, jobs, chunksize=4))
    sys.exit(0 if report(tried, asked.seed) else 1)
