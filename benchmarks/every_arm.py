"""Every shipped arm as its URDF has it: design, proof, bounds and a proven loop, each with its gap and its time.

    python benchmarks/every_arm.py [--only NAME] [--tables design,proof,bounds,loop] [--budget S] [--readme]

Four tables, and one command for them all. M̄ is what `design` finds for that arm and condition. A gap is the relative
distance of what is proven and what is found. Times are wall seconds on that many threads, and behind a slash the CPU
seconds of all threads together, which a busy machine changes little: on two idle cores a proof takes about half of
them. Kernels are compiled before.
"""

from __future__ import annotations

import argparse
import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin import DesignReport, SampledLoop, arm_names, bounds, certify_loop, design, load_arm
from asmc_pin.arms import Arm
from asmc_pin.condition.certificate import ProofProgress, certify
from asmc_pin.condition.norm.two_conditions import Condition
from asmc_pin.disk.files import write_whole

CONDITIONS: tuple[tuple[str, Condition], ...] = (("W", "weighted"), ("L", "lemma1"))
PERIOD, SLOPE, RATE, SHARE = 1e-3, 1.0, 200.0, 0.6  # of the loops: L, k_s, β, and M̄ over the best weighted one
HEADERS = {
    "design": "| arm | condition | least norm found | no M̄ has less than | gap of 1 − norm | programs | s / CPU s |",
    "proof": "| arm | condition | proven f | sup f | gap | boxes | f = 1 decided, s / CPU s | s / CPU s | end |",
    "bounds": "| arm | m₁ proven | λ_min found | gap | λ_max found | m₂ proven | gap | boxes | s / CPU s |",
    "loop": "| arm | λ(M⁻¹M̄) found | stable between | without gravity | at rest under 9.81 m/s² | boxes | s / CPU s |",
}
PAGE = Path(__file__).with_name("README.md")


class Stopwatch:
    """Wall and CPU seconds since it was made."""

    def __init__(self) -> None:
        self._wall, self._cpu = time.perf_counter(), time.process_time()

    def __str__(self) -> str:
        return f"{time.perf_counter() - self._wall:.2f} / {time.process_time() - self._cpu:.2f}"


def design_row(name: str, letter: str, arm: Arm, condition: Condition) -> tuple[DesignReport, list[str]]:
    """A design without its explanations."""
    watch = Stopwatch()
    found = design(arm, condition=condition, explain=False)
    took = str(watch)
    if found.check is None or found.bound is None:
        return found, [name, letter, "none", f"{found.bound}", "–", str(found.rounds), took]
    norm = found.check.lower
    gap = (norm - found.bound) / (1.0 - found.bound)
    return found, [name, letter, f"{norm:.6f}", f"{found.bound:.6f}", f"{gap:.2%}", str(found.rounds), took]


def proof_row(
    name: str, letter: str, arm: Arm, condition: Condition, mbar: Any, budget: float, threads: int
) -> list[str]:
    """A proof that goes for 1 %."""
    watch, decided = Stopwatch(), ""

    def look(state: ProofProgress) -> None:
        nonlocal decided
        if not decided and state.proven >= 1.0:
            decided = str(watch)

    found = certify(
        arm, mbar, condition=condition, gap=0.01, budget=budget, levels=False, threads=threads, progress=look
    )
    took = str(watch)
    reached = decided or (took if found.verdict != "undecided" else "–")
    scales = [f"{found.scale_proven:.5f}", f"{found.scale_refuted:.5f}", f"{found.gap:.2%}"]
    return [name, letter, *scales, str(found.boxes), reached, took, found.reason]


def bounds_row(name: str, arm: Arm, budget: float, threads: int) -> list[str]:
    """Least and largest eigenvalue of M."""
    watch = Stopwatch()
    found = bounds(arm, gap=0.01, budget=budget, threads=threads)
    took = str(watch)
    low, high = found.lower, found.upper
    cells = [name, "–" if low.proven is None else f"{low.proven:.5g}", f"{low.found:.5g}"]
    cells.append("–" if low.proven is None else f"{1.0 - low.proven / low.found:.2%}")
    cells += [f"{high.found:.5g}", "–" if high.proven is None else f"{high.proven:.5g}"]
    cells.append("–" if high.proven is None else f"{high.proven / high.found - 1.0:.2%}")
    return [*cells, str(found.boxes), took]


def loop_row(name: str, arm: Arm, mbar: Any, budget: float, threads: int) -> list[str]:
    """The plain loop with M̄ = 0.6 of the best under the weighted condition."""
    watch = Stopwatch()
    loop = SampledLoop(SHARE * np.asarray(mbar), SLOPE, RATE, PERIOD)
    found = certify_loop(arm, loop, budget=budget, threads=threads)
    took = str(watch)
    seen, stable = (f"{low:.4g} to {high:.4g}" for low, high in (found.seen_between, found.stable_between))
    said = {"stable": "proven", "unstable": "refuted", "undecided": f"open: {found.reason}"}[found.verdict]
    rest = "proven" if found.gravity is not None else found.no_gravity or "–"
    return [name, seen, stable, said, rest, str(found.boxes), took]


def rows_of(name: str, wanted: set[str], budget: float, threads: int) -> Iterator[tuple[str, list[str]]]:
    """The rows of one arm, with the table that each belongs to."""
    arm = load_arm(name)
    weighted = None
    for letter, condition in CONDITIONS:
        if wanted & {"design", "proof"} or (condition == "weighted" and "loop" in wanted):
            found, row = design_row(name, letter, arm, condition)
            weighted = found.mbar if condition == "weighted" else weighted
            if "design" in wanted:
                yield "design", row
            if "proof" in wanted and found.mbar is not None:
                yield "proof", proof_row(name, letter, arm, condition, found.mbar, budget, threads)
    if "bounds" in wanted:
        yield "bounds", bounds_row(name, arm, budget, threads)
    if "loop" in wanted and weighted is not None:
        yield "loop", loop_row(name, arm, weighted, budget, threads)


def _warm(threads: int) -> None:
    """Compile everything."""
    arm = load_arm("double_pendulum")
    for _, condition in CONDITIONS:
        mbar = design(arm, condition=condition, explain=False).mbar
        certify(arm, mbar, condition=condition, gap=0.5, budget=120.0, threads=threads)
    bounds(arm, gap=0.5)
    certify_loop(arm, SampledLoop(np.full(2, 1e-4), SLOPE, RATE, PERIOD))


def _told(header: str, rows: list[str]) -> str:
    return "\n".join([header, "|" + " --- |" * (header.count("|") - 1), *rows])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--only", default="", help="arms whose name contains this")
    parser.add_argument("--tables", default=",".join(HEADERS), help="which of design, proof, bounds, loop")
    parser.add_argument("--budget", type=float, default=120.0, help="wall seconds for each proof")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--readme", action="store_true", help="replace the tables of benchmarks/README.md")
    options = parser.parse_args()
    wanted = set(options.tables.split(","))
    if wanted - set(HEADERS):
        parser.error(f"--tables: {', '.join(sorted(wanted - set(HEADERS)))} given, of {', '.join(HEADERS)} expected")
    _warm(options.threads)
    tables: dict[str, list[str]] = {name: [] for name in HEADERS if name in wanted}
    for name in arm_names():
        if options.only in name:
            for table, cells in rows_of(name, wanted, options.budget, options.threads):
                tables[table].append("| " + " | ".join(cells) + " |")
                print(f"{table}: {tables[table][-1]}", flush=True)
    for table, rows in tables.items():
        print(f"\n{_told(HEADERS[table], rows)}")
    if options.readme:
        text = PAGE.read_text(encoding="utf-8")
        for table, rows in tables.items():
            pattern = re.compile(rf"(<!-- from here: {table} -->\n).*?(<!-- to here: {table} -->)", re.DOTALL)
            made = _told(HEADERS[table], rows)
            text = pattern.sub(_between(made), text)
        write_whole(PAGE, text)


def _between(made: str) -> Callable[[re.Match[str]], str]:
    return lambda match: f"{match[1]}{made}\n{match[2]}"


if __name__ == "__main__":
    main()
