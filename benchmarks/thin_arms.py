"""Arms whose last links have (nearly) no inertia about an axis: point masses and needles, proven or refuted to 1 %.

    python benchmarks/thin_arms.py [--only NAME] [--readme]

Textbook arms and exports of drawings are like that: M(q) is regular at every q, and a metric that forgets how small
one of its directions becomes proves nothing. M̄ is what `design` finds for the arm and condition.
"""

from __future__ import annotations

import argparse
import re
import tempfile
from collections.abc import Iterator
from pathlib import Path

from every_arm import CONDITIONS, PAGE, Stopwatch, _between, _told, _warm, design_row

from asmc_pin import load_arm
from asmc_pin.condition.certificate import certify
from asmc_pin.disk.files import write_whole

NEEDLE = 1e-9
"""Moment of a needle about its own axis over m l²."""
GOALS = {2: 10.0, 3: 10.0, 5: 60.0}
"""Seconds on two idle cores, by joints."""
HEADER = "| arm | condition | proven f | sup f | gap | boxes | goal, s | s / CPU s | end |"


def chain(joints: int, axes: str, needle: bool) -> str:
    """A chain of links of 1 m and 1 kg, the joints' axes as `axes` has them in turn (x, y or z of the link before)."""
    inertia = (NEEDLE, 1.0 / 12.0, 1.0 / 12.0) if needle else (0.0, 0.0, 0.0)
    moments = " ".join(f'{key}="{value!r}"' for key, value in zip(("ixx", "iyy", "izz"), inertia, strict=True))
    parts = ['<robot name="thin"><link name="l0"/>']
    for k in range(1, joints + 1):
        axis = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}[axes[(k - 1) % len(axes)]]
        parts.append(
            f'<link name="l{k}"><inertial><origin xyz="0.5 0 0"/><mass value="1"/>'
            f'<inertia {moments} ixy="0" ixz="0" iyz="0"/></inertial></link>'
            f'<joint name="j{k}" type="revolute"><parent link="l{k - 1}"/><child link="l{k}"/>'
            f'<origin xyz="{"1" if k > 1 else "0"} 0 0"/><axis xyz="{axis}"/>'
            f'<limit lower="-3.1" upper="3.1" effort="100" velocity="3"/></joint>'
        )
    return "".join(parts) + "</robot>"


CASES = {
    f"{joints} {what}": (joints, axes, needle)
    for joints in (2, 3, 5)
    for what, axes, needle in (
        ("point masses in a plane", "z", False),
        ("needles in a plane", "z", True),
        ("needles, crossed axes", "zy", True),
    )
}


def rows(only: str, threads: int, budget: float | None) -> Iterator[list[str]]:
    """A row for each case and condition."""
    with tempfile.TemporaryDirectory() as folder:
        for name, (joints, axes, needle) in CASES.items():
            if only not in name:
                continue
            path = Path(folder) / "thin.urdf"
            path.write_text(chain(joints, axes, needle), encoding="utf-8")
            arm = load_arm(path)
            for letter, condition in CONDITIONS:
                found, _ = design_row(name, letter, arm, condition)
                if found.mbar is None:
                    yield [name, letter, *["–"] * 6, "no M̄"]
                    continue
                watch, goal = Stopwatch(), GOALS[joints]
                proof = certify(
                    arm, found.mbar, condition=condition, gap=0.01, budget=budget or goal, levels=False, threads=threads
                )
                scales = [f"{proof.scale_proven:.5g}", f"{proof.scale_refuted:.5g}", f"{proof.gap:.2%}"]
                yield [name, letter, *scales, str(proof.boxes), f"{goal:g}", str(watch), proof.reason]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--only", default="", help="cases whose name contains this")
    parser.add_argument("--budget", type=float, help="seconds, in place of the goals")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--readme", action="store_true", help="replace the table of benchmarks/README.md")
    options = parser.parse_args()
    _warm(options.threads)
    made = []
    for cells in rows(options.only, options.threads, options.budget):
        made.append("| " + " | ".join(cells) + " |")
        print(made[-1], flush=True)
    if options.readme:
        pattern = re.compile(r"(<!-- from here: thin -->\n).*?(<!-- to here: thin -->)", re.DOTALL)
        write_whole(PAGE, pattern.sub(_between(_told(HEADER, made)), PAGE.read_text(encoding="utf-8")))


if __name__ == "__main__":
    main()
