"""Gap of a certificate against time, arm by arm: what is proven, of what was refuted, after how many seconds.

    python benchmarks/certificate.py [--only NAME] [--budget S] [--threads 2]

M̄ is what `design` finds for that arm, armature and condition. The kernels are compiled before the clock starts; the
search that refutes is inside it. `sup f` is the factor of M̄ at which a counter-example was found; `proven f` the factor
up to which the condition is proven over the whole joint box; the gap is their relative distance.
"""

from __future__ import annotations

import argparse

import numpy as np

from asmc_pin import design, load_arm
from asmc_pin.condition.certificate import CertificateResult, certify
from asmc_pin.condition.domain.along_motion import motion_of, tube
from asmc_pin.references import Ramps

MID6, MID7 = [0.5, 0.5, 0.3, 0.05, 0.05, 0.05], [0.5, 0.5, 0.3, 0.3, 0.05, 0.05, 0.05]
LOW6, LOW7 = [0.1, 0.1, 0.1, 0.01, 0.01, 0.01], [0.1] * 4 + [0.01] * 3

# name: arm, armature, condition, gap asked, budget in s, the goal in words.
CASES = {
    "ur5 low W": ("ur5", LOW6, "weighted", 0.005, 10, "0.5 % in 1 s"),
    "ur5 mid W": ("ur5", MID6, "weighted", 0.005, 10, "0.5 % in 1 s"),
    "z1 low W": ("z1", LOW6, "weighted", 0.005, 10, "0.5 % in 1 s"),
    "z1 mid W": ("z1", MID6, "weighted", 0.005, 10, "0.5 % in 1 s"),
    "z1 bare W": ("z1", None, "weighted", 0.03, 15, "3 % in 15 s"),
    "panda mid W": ("panda", MID7, "weighted", 0.01, 30, "f ≥ 1 in 10 s"),
    "xarm7 mid W": ("xarm7", MID7, "weighted", 0.01, 30, "f ≥ 1 in 10 s"),
    "panda bare W": ("panda", None, "weighted", 0.01, 60, "f ≥ 0.8 in 60 s, 0.9 in 300 s"),
    "xarm7 bare W": ("xarm7", None, "weighted", 0.01, 60, "f ≥ 0.8 in 60 s, 0.9 in 300 s"),
    "kinova bare W": ("kinova", None, "weighted", 0.01, 60, "f ≥ 1 in 60 s"),
    "two_link L": ("two_link", None, "lemma1", 0.001, 5, "0.1 % in 1 s"),
    "double_pendulum L": ("double_pendulum", None, "lemma1", 0.001, 5, "0.1 % in 1 s"),
    "ur5 bare L": ("ur5", None, "lemma1", 0.02, 60, "5 % in 45 s, 2 % in 300 s"),
    "z1 bare L": ("z1", None, "lemma1", 0.02, 30, "10 % in 15 s"),
    "panda mid L": ("panda", MID7, "lemma1", 0.02, 60, "as far as it goes"),
    "xarm7 mid L": ("xarm7", MID7, "lemma1", 0.02, 60, "as far as it goes"),
    "panda low L": ("panda", LOW7, "lemma1", 0.02, 60, "as far as it goes"),
    "xarm7 low L": ("xarm7", LOW7, "lemma1", 0.02, 60, "as far as it goes"),
    "kinova bare L": ("kinova", None, "lemma1", 0.01, 60, "f ≥ 1 in 60 s"),
    "panda bare L": ("panda", None, "lemma1", 0.01, 120, "f ≥ 1 in 60 s, 1 % in 120 s"),
    "xarm7 bare L": ("xarm7", None, "lemma1", 0.01, 120, "f ≥ 1 in 60 s, 1 % in 120 s"),
}
# Tubes of ±0.5 rad around a motion through the joint box, every time slice a box of its own: arm, armature.
TUBES = {
    "panda mid tube": ("panda", MID7),
    "xarm7 mid tube": ("xarm7", MID7),
    "panda low tube": ("panda", LOW7),
    "xarm7 low tube": ("xarm7", LOW7),
}
SHARES = (0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.001)


def when(result: CertificateResult, share: float) -> str:
    """Seconds after which the gap to the final counter-example was at most `share`."""
    enough = [seconds for seconds, proven in result.history if proven >= (1.0 - share) * result.scale_refuted]
    return f"{enough[0]:.2f}" if enough else "–"


def tubes(only: str, threads: int) -> None:
    """Each time slice of a tube on its own: the scale proven in 5 s at most, and when 0.8 was reached."""
    print(
        "\n| case | slices | least f proven | most s to f ≥ 0.8 | most s to gap ≤ 5 % |\n|" + " --- |" * 5, flush=True
    )
    for name, (arm_name, armature) in TUBES.items():
        if only not in name:
            continue
        arm = load_arm(arm_name, armature=armature)
        mbar = np.asarray(design(arm, condition="lemma1", explain=False).mbar)
        lower, upper = arm.box
        share = np.array([0.25, 0.75, 0.25, 0.75, 0.25, 0.75, 0.25])
        ends = [(lower + s * (upper - lower)).tolist() for s in (share, np.full(7, 0.5), 1.0 - share)]
        motion = motion_of(Ramps(points=ends, times=[0.0, 2.0, 4.0]), arm.nv)
        slices = tube(motion, 0.5, 20)
        found = [
            certify(arm, mbar, box=(s.lower, s.upper), gap=0.05, budget=5.0, levels=False, threads=threads)
            for s in slices
        ]
        reached = [next((t for t, f in result.history if f >= 0.8), np.inf) for result in found]
        seconds = max(result.seconds for result in found)
        least = min(result.scale_proven for result in found)
        print(f"| {name} | {len(slices)} | {least:.4f} | {max(reached):.2f} | {seconds:.2f} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--only", default="", help="cases whose name contains this")
    parser.add_argument("--budget", type=float, help="seconds, in place of each case's own")
    parser.add_argument("--threads", type=int, default=2)
    options = parser.parse_args()

    warm = load_arm("double_pendulum")
    for condition in ("weighted", "lemma1"):  # compiles
        certify(warm, 1e-4, condition=condition, gap=0.5, budget=120, threads=options.threads)
    columns = ["case", "goal", "proven f", "sup f", "gap", "norm ≤", *(f"{share:.1%}" for share in SHARES)]
    if any(options.only in name for name in CASES):
        print("| " + " | ".join(columns) + " |\n|" + " --- |" * len(columns), flush=True)
    for name, (arm_name, armature, condition, gap, budget, goal) in CASES.items():
        if options.only not in name:
            continue
        arm = load_arm(arm_name, armature=armature)
        mbar = np.asarray(design(arm, condition=condition, explain=False).mbar)
        result = certify(
            arm, mbar, condition=condition, gap=gap, budget=options.budget or budget, threads=options.threads
        )
        upper = "–" if result.upper is None else f"{result.upper:.4f}"
        row = [name, goal, f"{result.scale_proven:.4f}", f"{result.scale_refuted:.4f}", f"{result.gap:.2%}", upper]
        print("| " + " | ".join([*row, *(when(result, share) for share in SHARES)]) + " |", flush=True)
    tubes(options.only, options.threads)


if __name__ == "__main__":
    main()
