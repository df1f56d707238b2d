"""Bounds of M(q) on the shipped arms, proven beside found; the table of docs/bounds.md, and proofs of loops.

    python benchmarks/bounds.py [--only NAME] [--budget S] [--threads 2] [--docs docs/bounds.md]

The arms stand as their URDFs have them, without rotor inertia, and once with 0.1 kg·m² (kg) at every joint, over their
whole joint boxes. m₁ and m₂ are proven and found, so are the condition number's largest value and the c of
‖C(q, q̇)q̇‖ ≤ c‖q̇‖². The loops are the plain one at 1 ms with M̄ = 0.6 of the best under the weighted condition.
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

import numpy as np

from asmc_pin import BoundsReport, SampledLoop, arm_names, bounds, certify_loop, design, load_arm
from asmc_pin.arms import Arm
from asmc_pin.disk.files import write_whole
from asmc_pin.words.text import rounded_down, rounded_up

ARMATURES = (None, 0.1)
GAINS = ((20.0, 20.0), (1.0, 200.0))
HEADER = (
    "| arm | armature | m₁ proven | λ_min found | λ_max found | m₂ proven | λ_max/λ_min found | proven ≤ | c found | "
    "c proven | s |"
)
LOOPS = "| arm | armature | k_s, β | λ(M⁻¹M̄) found | stable between | without gravity | at rest under 9.81 m/s² | s |"


def row(name: str, armature: float | None, report: BoundsReport) -> str:
    """One arm; what is proven is rounded to the safe side."""
    low, high, ratio, forces = report.lower, report.upper, report.condition_number, report.coriolis
    cells = [
        name,
        "own" if armature is None else f"{armature:g}",
        "–" if low.proven is None else rounded_down(low.proven, 4),
        f"{low.found:.4g}",
        f"{high.found:.4g}",
        "–" if high.proven is None else rounded_up(high.proven, 4),
        f"{ratio.found:.4g}",
        "–" if ratio.proven is None else rounded_up(ratio.proven, 4),
        f"{forces.found:.3g}",
        "–" if forces.proven is None else rounded_up(forces.proven, 3),
        f"{report.seconds:.1f}",
    ]
    return "| " + " | ".join(cells) + " |"


def loop_rows(name: str, armature: float | None, arm: Arm, budget: float, threads: int) -> list[str]:
    """The loops of one arm."""
    mbar = design(arm, condition="weighted", explain=False).mbar
    if mbar is None:
        return []
    rows = []
    for ks, beta in GAINS:
        proof = certify_loop(arm, SampledLoop(0.6 * np.asarray(mbar), ks, beta, 1e-3), budget=budget, threads=threads)
        cells = [
            name,
            "own" if armature is None else f"{armature:g}",
            f"{ks:g}, {beta:g}",
            f"{proof.seen_between[0]:.4g} to {proof.seen_between[1]:.4g}",
            f"{proof.stable_between[0]:.4g}, {proof.stable_between[1]:.4g}",
            {"stable": "proven", "unstable": "refuted", "undecided": "open"}[proof.verdict],
            "proven" if proof.gravity is not None else "–",
            f"{proof.seconds:.1f}",
        ]
        rows.append("| " + " | ".join(cells) + " |")
    return rows


def told(header: str, rows: list[str]) -> str:
    """A table in Markdown."""
    return "\n".join([header, "|" + " --- |" * (header.count("|") - 1), *rows])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--only", default="", help="arms whose name contains this")
    parser.add_argument("--budget", type=float, default=20.0, help="seconds for the bounds of one arm")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--docs", help="a page whose tables are replaced")
    options = parser.parse_args()

    bounds(load_arm("double_pendulum"), gap=0.5)  # compiles
    tables: dict[str, tuple[str, list[str]]] = {"bounds": (HEADER, []), "loops": (LOOPS, [])}
    for header, _ in tables.values():
        print(header)
    for name in arm_names():
        if options.only not in name:
            continue
        for armature in ARMATURES:
            arm = load_arm(name, armature=armature)
            report = bounds(arm, gap=0.01, budget=options.budget, threads=options.threads)
            tables["bounds"][1].append(row(name, armature, report))
            print(tables["bounds"][1][-1], flush=True)
            for line in loop_rows(name, armature, arm, options.budget, options.threads):
                tables["loops"][1].append(line)
                print(line, flush=True)
    if options.docs:
        page = Path(options.docs)
        text = page.read_text(encoding="utf-8")
        for place, (header, rows) in tables.items():
            pattern = re.compile(rf"(<!-- from here: {place} -->\n).*?(<!-- to here: {place} -->)", re.DOTALL)
            made = told(header, rows)
            text = pattern.sub(lambda match, made=made: match[1] + made + "\n" + match[2], text)
        write_whole(page, text)


if __name__ == "__main__":
    main()
