"""The sound inputs that all others are made from; making them also loads and compiles what every command needs."""

from __future__ import annotations

import contextlib
import io
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

from arm_urdf import two_joints

from asmc_pin.cli import main
from asmc_pin.disk.resources import shipped

TINY_EXPERIMENTS = {
    "first": """
name = "first"
arm = "two_link"
period = 0.001
duration = 0.02
[plant]
friction = { coulomb = 1.0, viscous = 0.1 }
[reference]
kind = "multisine"
offset = [0.3, 0.2]
amplitude = [[0.2], [0.2]]
frequency = [[0.5], [0.5]]
[defaults]
mbar = 0.01
ks = 5.0
beta = 5.0
[controllers.PPC]
law = "ppc"
[controllers.Proposed]
law = "baek2016"
phi = 800.0
alpha = 0.03
epsilon = 0.01
""",
    "second": """
name = "second"
arm = { source = "two_link", payload = 1.0 }
period = 0.002
duration = 0.03
[reference]
kind = "quintic"
start = [0.1, 0.2]
targets = [[0.12, 0.15]]
move = 0.05
[controllers.PD]
law = "pd_gravity"
kp = 100.0
kd = 10.0
""",
}


def run(command: str, *words: object, verdicts: tuple[int, ...] = (0,)) -> None:
    """Run the command line in this process, all words of a command and some more; it must end with such a status."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main([*command.split(), *map(str, words)])
        except SystemExit as end:
            ended = end.code
    if ended not in verdicts:
        raise RuntimeError(f"asmc-pin {command} {words} ended with {ended}: {err.getvalue()}")


def urdfs(folder: Path) -> list[bytes]:
    """Shipped arms, a small one, and arms of example-robot-data."""
    from asmc_pin import load_arm

    found = [path.read_bytes() for path in sorted(shipped("urdf").rglob("*.urdf"))]
    found += [two_joints().encode(), *(load_arm(name).urdf_text.encode() for name in ("so100", "kinova"))]
    (folder / "a.urdf").write_bytes(found[0])
    (folder / "b.urdf").write_text(two_joints(), encoding="utf-8")
    for path in (folder / "a.urdf", folder / "b.urdf"):
        run("verify --mbar 1e-3 --samples 64 --json", path)
        run("verify --mbar 1e-3 --samples 64 --condition weighted", path)
        run("agree", path)
        run("stability --mbar 0.01 --ks 10 --beta 10 --period 0.001", path, verdicts=(0, 1))
    run("verify --mbar 1e-3 --certify --budget 5 --gap 0.5", path)
    run("design", path)
    return found


def experiments(folder: Path) -> list[bytes]:
    """Shipped experiments; those that are run take some ticks only, see `generate_toml.shorten`."""
    results(folder)
    return [path.read_bytes() for path in sorted(shipped("experiments").glob("*.toml"))]


def certificates(folder: Path) -> list[bytes]:
    """Small proofs of every sort: both conditions, ranges, choices, slides, a tube, a counter-example alone."""
    from condition_cases import chain

    sliding = chain(folder, 4, 2, prismatic=True)
    light, arm = "two_link --certify --gap 0.1 --budget 20", str(sliding.source)
    proofs = [
        f"{light} --mbar 0.01 --condition weighted",
        f"{light} --mbar 0.01",
        f"{light} --mbar 0.01,0.02 --payload 0:1 --armature 0:0.1 --condition weighted --box joint_2=0.5:1",
        f"{light} --mbar 0.01 --lock joint_2=0.1,0.5 --condition weighted",
        f"{arm} --certify --gap 0.3 --budget 20 --mbar 0.001 --payload 0.5",
    ]
    for k, words in enumerate(proofs):
        run(f"verify {words} --samples 256 --certificate", folder / f"{k}.cert")
    violated = "two_link --certify --gap 0.1 --budget 20 --condition weighted --mbar 5 --samples 256"
    run(f"verify {violated} --certificate", folder / "violated.cert", verdicts=(1,))
    (folder / "motion.toml").write_text(TINY_EXPERIMENTS["first"], encoding="utf-8")
    run(f"verify {light} --mbar 0.01 --tube 0.05 --along motion.toml --certificate tube.cert")
    for path in sorted(folder.glob("*.cert")):
        run("check --json", path, verdicts=(0, 1))
    return [path.read_bytes() for path in sorted(folder.glob("*.cert"))]


def results(folder: Path) -> list[Path]:
    """Two small results, without their figures."""
    made = []
    for name, text in TINY_EXPERIMENTS.items():
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
        run("compare", folder / f"{name}.toml", "--out", folder / name)
        run("view", folder / name, "--html", folder / "page.html")
        run("verify two_link --mbar 0.01 --json --along", folder / f"{name}.toml")
        shutil.rmtree(folder / name / "figures")
        made.append(folder / name)
    return made


CORPORA: dict[str, Callable[[Path], Any]] = {
    "urdf": urdfs,
    "toml": experiments,
    "certificate": certificates,
    "result": results,
}


def make(kind: str, folder: Path) -> Any:
    """The sound inputs of a kind, made in a folder."""
    place = folder / kind
    place.mkdir(parents=True)
    before = Path.cwd()
    os.chdir(place)
    try:
        return CORPORA[kind](place)
    finally:
        os.chdir(before)
