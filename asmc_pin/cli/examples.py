"""What help shows at the end of each command: lines that can be pasted, the common one first."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

EXAMPLES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "verify": (
            "verify ur5 --mbar 0.148,0.167,0.150,0.081,0.093,0.0171",
            "verify my_robot.urdf --mbar 0.1 --payload 0:3 --box elbow_joint=-2:2",
            "verify two_link --mbar 0.02 --certify --budget 2m --certificate two_link.cert",
        ),
        "bounds": ("bounds two_link", "bounds ur5 --payload 0:3 --budget 2m --json"),
        "design": (
            "design ur5",
            "design ur5 --gains --period 0.001 --payload 0:3",
            "design two_link --certify --certificate two_link.cert --report two_link.html",
        ),
        "check": ("check two_link.cert", "check two_link.cert --json"),
        "stability": (
            "stability two_link --mbar 0.02 --ks 5 --beta 5 --period 0.001",
            "stability two_link --mbar 0.02 --ks 5,8 --beta 5 --period 0.001 --delay 1 --encoder-bits 17",
            "stability two_link --mbar 0.02 --ks 5 --beta 5 --period 0.001 --report loop.html",
        ),
        "new": ("new mine.toml --from demo", "new pick.toml --from panda_pick"),
        "compare": ("compare demo", "compare mine.toml --out results/first --refine"),
        "report": ("report demo", "report results/first"),
        "demo": ("demo",),
        "tune": ("tune ur5_tuning", "tune mine.toml --trials 128 --report tuned.html"),
        "sweep": ("sweep ur5_robustness --trials 64", "sweep ur5_robustness --trials 64 --replay 17"),
        "reproduce": ("reproduce", "reproduce simulation_smooth --no-search"),
        "bench": ("bench --quick",),
        "export": ("export demo Proposed --out proposed_in_c",),
        "view": (
            "view demo",
            "view demo --html demo.html",
            "view demo --png demo.png --time 2.5",
            "view demo --mp4 demo.mp4",
            "view ur5_robustness-sweep --follow",
        ),
        "explore": (
            "explore ur5 --mbar 0.148,0.167,0.150,0.081,0.093,0.0171",
            "explore ur5 --mbar 0.148,0.167,0.150,0.081,0.093,0.0171 --certify --html ur5.html",
            "explore two_link --mbar 0.02 --ks 5 --beta 5 --period 0.001",
        ),
        "inspect": (
            "inspect ur5 --html ur5.html",
            "inspect my_robot.urdf --package my_robot_description=./description",
        ),
        "identify": (
            "identify ur5 log.csv --out measured.toml --report page.html",
            "identify my_robot.urdf log.csv.gz --torque-side link --columns tau=effort_{n}",
            "identify ur5 log.csv --law demo PPC --report page.html",
            "identify ur5 rosbag2_2026_11_28/ --topic /joint_states",
            "identify ur5 log.csv --degrees --motor-constant 12.1,12.1,10.9,9.5,9.5,9.5",
        ),
        "arms": ("arms", "arms --json"),
        "controllers": ("controllers", "controllers baek2016"),
        "experiments": ("experiments",),
        "agree": ("agree two_link", "agree ur5 --payload 2"),
    }
)
"""Words after ``asmc-pin`` by command; a test holds that every command has some and takes them."""


def shown_examples(command: str) -> str | None:
    """The paragraph below a command's options; None where it has no example."""
    lines = EXAMPLES.get(command)
    return None if lines is None else "Examples:\n\n" + "\n\n".join(f"  asmc-pin {line}" for line in lines)
