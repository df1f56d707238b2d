"""What the page on M̄ says in words and in its tables."""

from __future__ import annotations

from importlib.metadata import version
from typing import TYPE_CHECKING

import numpy as np

from asmc_pin.condition import Condition, ConditionReport, DesignReport
from asmc_pin.condition.hypotheses import NAMES
from asmc_pin.words.joint_units import Quantity, column_cells, column_head, joint_units
from asmc_pin.words.text import printable, rounded_down, rounded_up

if TYPE_CHECKING:
    from asmc_pin.arms import Arm

CONTINUOUS = (
    "It is a statement in continuous time: a sampled loop needs more, and its gains have to be checked separately."
)

_SCOPE = {
    "box": "over the joint box below",
    "motion": "along the motion",
    "tube": "in the tube around the motion",
}


def headline(report: ConditionReport | DesignReport) -> str:
    """Condition, arm with all that is supposed about it, and the verdict."""
    return f"{NAMES[report.condition]} on {report.hypotheses.title}: {report.verdict}"


def sentence(report: ConditionReport | DesignReport) -> str:
    """The verdict in one or two sentences, claiming no more than was shown."""
    if isinstance(report, DesignReport):
        if report.check is None:
            bound = (
                ""
                if report.bound is None
                else f": no norm is below {rounded_down(report.bound)} on these configurations (rigorous dual bound)"
            )
            return f"No M̄ within the bounds satisfies the condition on {report.hypotheses.title}{bound}."
        return (
            f"The M̄ below was designed for {_objective(report)}. "
            f"No M̄ within the bounds has a norm below {rounded_down(report.bound or 0.0)} (rigorous dual bound). "
            f"{sentence(report.check)}"
        )
    arm, where = report.hypotheses.title, _SCOPE[report.scope]
    if report.verdict == "violated":
        norm = f"the norm is {report.lower:.6g}, not below 1"
        return f"On {arm}, M̄ violates the condition: at the configuration below {norm}."
    if report.verdict == "holds":
        bound = "below 1" if report.upper is None or report.upper >= 1.0 else f"at most {rounded_up(report.upper)}"
        return f"On {arm}, proven {where}: the norm is {bound}. The largest that was found is {report.lower:.6g}."
    if report.verdict == "undecided":
        return (
            f"On {arm}, neither proven nor refuted {where} within the budget; the largest norm found is "
            f"{report.lower:.6g}."
        )
    return (
        f"On {arm}, no configuration that violates the condition was found {where}; the largest norm found is "
        f"{report.lower:.6g}. This is a search and not a proof."
    )


def _objective(report: DesignReport) -> str:
    if report.objective == "contraction":
        return "the least norm"
    return f"the largest λ_min(M⁻¹M̄) with a norm of at most {report.level:.6g}"


def facts(report: ConditionReport | DesignReport, arm: Arm) -> list[tuple[str, str]]:
    """Terms and what they are: all that is needed to check or repeat the statement."""
    check = report.check if isinstance(report, DesignReport) else report
    found = [
        *(report.rows() if isinstance(report, DesignReport) else report.hypotheses.rows()),
        ("URDF", printable(arm.source.name)),
        ("SHA-256 of the URDF", arm.sha256),
    ]
    if check is not None:
        if check.worst_case:
            found.append(("Worst of the cases", printable(check.worst_case)))
        found += [
            ("Norm, largest found", repr(check.lower)),
            ("Norm, proven bound", "none: sampled only" if check.upper is None else repr(check.upper)),
            ("Norm, smallest sampled", f"{check.smallest:.6g}"),
        ]
        if check.scale_proven is not None or check.scale_refuted is not None:
            found += [
                ("Proven for M̄ times", _or_dash(check.scale_proven)),
                ("Refuted for M̄ times", _or_dash(check.scale_refuted)),
            ]
        if check.worst_time is not None:
            found.append(("Time of the largest", f"{check.worst_time:g} s"))
        if check.tde_error is not None:
            error = check.tde_error[~np.isnan(check.tde_error).any(axis=1)]
            rms = ", ".join(f"{value:.4g}" for value in np.sqrt(np.mean(error**2, axis=0)))
            found.append(("TDE error that M̄ would have made, RMS", f"{rms} rad/s² (m/s² where prismatic)"))
        found += [("Method", "; ".join(check.method)), ("Configurations evaluated", str(check.configurations))]
    found += [("Wall time", f"{report.seconds:.3g} s"), ("Software", f"asmc-pin {version('asmc-pin')}")]
    return found


def joint_table(check: ConditionReport) -> tuple[list[str], list[list[str]]]:
    """Header and rows: range, m̄, armature and the worst configuration of every joint; m̄ with all its digits."""
    kinds = dict(zip(check.subject.joint_names, check.subject.joint_kinds, strict=True))
    slides = [kinds[joint] == "prismatic" for joint in check.joints]
    columns: dict[str, tuple[Quantity, list[str]]] = {
        "m̄": ("inertia", [repr(float(value)) for value in check.mbar]),
        "armature at the worst": ("inertia", [f"{value:g}" for value in check.worst_armature]),
        "worst q": ("place", [f"{round(float(value), 6) + 0.0:.6f}" for value in check.worst_q]),
    }
    head = ["joint", "range", *(column_head(name, what, slides) for name, (what, _) in columns.items()), "worst q deg"]
    cells = [column_cells(figures, what, slides) for what, figures in columns.values()]
    units = joint_units("place", slides)
    rows = []
    for i, joint in enumerate(check.joints):
        degrees = "" if slides[i] else f"{round(float(np.degrees(check.worst_q[i])), 2) + 0.0:.2f}"
        ends = f"{check.box[0][i]:.5g} … {check.box[1][i]:.5g} {units[i]}"
        rows.append([printable(joint), ends, *(column[i] for column in cells), degrees])
    return head, rows


def meaning(condition: Condition) -> list[str]:
    """What the condition is for, and how it relates to the other one."""
    common = (
        "Time-delay estimation puts the last sample, Γ̂(t) = q̈(t−L) − M̄⁻¹τ(t−L), in the place of all that is not known. "
        "Its error N = Γ − Γ̂ obeys N_k ≈ (I − M(q)⁻¹M̄) N_{k−1} + drift, so it stays bounded where this map contracts."
    )
    if condition == "lemma1":
        return [
            common,
            "Lemma 1 of Baek, Jin and Han (2016, DOI 10.1109/TIE.2016.2522386) asks for ‖I − M(q(t))⁻¹M̄‖₂ < 1 at all "
            "times, which is the linear matrix inequality M̄⁻¹M + M M̄⁻¹ ≻ I.",
            CONTINUOUS,
        ]
    return [
        common,
        "The weighted condition asks for M̄ ≺ 2M(q), that is max|1 − λ(M⁻¹M̄)| < 1: the same error contracts in the "
        "constant weighting M̄^½. Lemma 1 of Baek, Jin and Han (2016) implies it, and it does not imply Lemma 1: what "
        "is said here is not a statement about Lemma 1.",
        CONTINUOUS,
    ]


def _or_dash(value: float | None) -> str:
    return "—" if value is None else repr(value)
