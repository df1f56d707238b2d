"""Where exported code comes from and what is proven about it, in lines for its header."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from asmc_pin.arms import Arm
from asmc_pin.arms.robot_limits import LIMITED_QUANTITIES
from asmc_pin.condition.checker import check
from asmc_pin.condition.checker.loop_conclusion import LoopConclusion
from asmc_pin.condition.hypotheses import Hypotheses
from asmc_pin.controllers import TdeLaw
from asmc_pin.disk.file_access import check_readable
from asmc_pin.errors import ParameterError
from asmc_pin.experiment import Experiment
from asmc_pin.experiment.toml_text import write_toml


def provenance_lines(
    experiment: Experiment, label: str, arm: Arm, law: TdeLaw, certificate: str | Path | None
) -> list[str]:
    """Experiment, arm and law by name and hash, and what a certificate says of them.

    Raises:
        ParameterError: the certificate is not valid, or is about another arm, M̄ or loop.
        ResultError: it cannot be read.
    """
    gains = write_toml({"controllers": {label: {**experiment.defaults, **experiment.controllers[label]}}})
    return [
        f"asmc-pin {version('asmc-pin')}",
        f"experiment: {experiment.name}, SHA-256 {_digest(experiment.to_toml())}",
        *(f"  {line}" for line in experiment.lines()),
        f"arm: {arm.name}, SHA-256 of its URDF {arm.sha256}",
        f"law, as defaults and table of the controller give it; its period is {law.period!r} s:",
        *(f"  {line}" for line in gains.strip().split("\n")),
        *_robot(experiment),
        *_certified(certificate, arm, law),
    ]


def _robot(experiment: Experiment) -> list[str]:
    robot = experiment.robot_limits
    if robot is None:
        return []
    lines = [f"limits of torque and torque rate: within those published of {robot.robot}, or tighter where asked for:"]
    for name, (words, unit) in LIMITED_QUANTITIES.items():
        limit = robot.published.get(name)
        if limit is None:
            lines.append(f"  {words}: not published")
        else:
            kept = "; not watched here" if name == "velocity" else ""
            lines.append(f"  {words}, {unit}: {', '.join(f'{x:.4g}' for x in limit.values)}{kept}. {limit.source}")
    return lines


def _certified(certificate: str | Path | None, arm: Arm, law: TdeLaw) -> list[str]:
    if certificate is None:
        return ["certificate: none was given. Nothing is proven here about this M and these gains."]
    path = Path(certificate)
    check_readable(path, "the certificate")
    found = check(path)
    if not found.valid or found.hypotheses is None or found.conclusion is None:
        told = found.problems[0] if found.problems else "it proves nothing"
        raise ParameterError("certificate", f"{path} is not valid: {told}; give one that `asmc-pin check` accepts")
    about = found.hypotheses
    _same("the URDF's SHA-256", about.sha256, arm.sha256, path)
    _same("the joints", list(about.joints), list(arm.joint_names), path)
    if isinstance(found.conclusion, LoopConclusion):
        loop = found.conclusion
        for name, proven, own in (
            ("M̄", loop.mbar, law.mbar),
            ("K_s", loop.ks, law.ks),
            ("β", loop.beta, law.beta),
            ("the period", loop.period, law.period),
        ):
            _same(name, proven, own, path)
    elif isinstance(about, Hypotheses):
        # A law that low-passes its whole estimate asks the condition of cM̄.
        _same("M̄", about.mbar, law.estimate_weight * law.mbar, path)
    return [
        f"certificate: {path.name}, SHA-256 {hashlib.sha256(path.read_bytes()).hexdigest()}, checked again:",
        *(f"  {line}" for line in [*found.conclusion.lines(), *about.lines()]),
        f"  It holds for that range, payload and armature alone; this code is for a period of {law.period!r} s.",
    ]


def _same(what: str, proven: Any, own: Any, path: Path) -> None:
    if isinstance(proven, str) or (isinstance(proven, Sequence) and proven and isinstance(proven[0], str)):
        equal = proven == own
    else:
        a, b = np.asarray(proven, dtype=np.float64), np.asarray(own, dtype=np.float64)
        equal = bool((np.broadcast_to(b, a.shape) == a).all()) if b.ndim <= a.ndim else bool((a == b).all())
    if not equal:
        raise ParameterError(
            "certificate", f"{what} in {path} is {_shown(proven)}, here it is {_shown(own)}; give a certificate of this"
        )


def _shown(value: Any) -> str:
    return str(value.tolist() if isinstance(value, np.ndarray) else value)


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
