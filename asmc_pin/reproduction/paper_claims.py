"""The paper's claims, each judged by the figures of one experiment: what was measured, and whether it holds."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from asmc_pin.pages.tables.text_table import number
from asmc_pin.reproduction.printed_tables import BSMC, EXISTING, NORM, PPC, PROPOSED, TUNED_SUFFIX, Printed

HOLDS, PART, BROKEN, NOT_APPLICABLE = "holds", "in part", "does not hold", "not applicable"

Figures = Mapping[str, Mapping[str, Any]]


def judged_claims(measured: Figures, norm: Sequence[float], printed: Printed) -> dict[str, dict[str, str]]:
    """Every claim, on one experiment.

    Args:
        measured: By label what `asmc_pin.reproduction.measured_figures` gives.
        norm: Range of ‖I − M⁻¹M̄‖₂ along the measured motion.
        printed: What the paper prints of this experiment.

    Returns:
        By claim: ``verdict`` and ``evidence``.
    """
    verdicts = {name: claim(measured, printed) for name, claim in _CLAIMS.items()}
    verdicts["norm range"] = _norm_range(norm, printed)
    return {name: {"verdict": verdict, "evidence": evidence} for name, (verdict, evidence) in verdicts.items()}


def _last(measured: Figures, printed: Printed) -> tuple[str, str]:
    """PPC is the least accurate, at both joints."""
    return _ordering(measured, lambda labels, _proposed: (PPC, len(labels)))


def _first(measured: Figures, printed: Printed) -> tuple[str, str]:
    """The proposed law is the most accurate, at both joints."""
    return _ordering(measured, lambda _labels, proposed: (proposed, 1))


def _ordering(measured: Figures, wanted: Callable[[Sequence[str], str], tuple[str, int]]) -> tuple[str, str]:
    """Whether a law has its place among the others: all untuned, the baselines tuned, and all tuned."""
    baselines = [label for label in (BSMC, EXISTING) if label in measured]
    tuned = [label + TUNED_SUFFIX for label in baselines if label + TUNED_SUFFIX in measured]
    rounds = {
        "all untuned": [*baselines, PROPOSED],
        "baselines tuned, proposed with the gains of the file": [*tuned, PROPOSED],
        "all tuned": [*tuned, PROPOSED + TUNED_SUFFIX],
    }
    good: list[bool | None] = []
    told = []
    for name, labels in rounds.items():
        if len(labels) < 2 or labels[-1] not in measured:
            continue
        labels = [PPC, *labels]
        label, place = wanted(labels, labels[-1])
        places = [_places(measured, labels, label, joint) for joint in (0, 1)]
        good += [None if low != high and low <= place <= high else low == place for low, high in places]
        told.append(f"{name}: {label} {' and '.join(map(_place_words, places))} of {len(labels)}")
    return _grade(good), "; ".join(told)


def _places(measured: Figures, labels: Sequence[str], label: str, joint: int) -> tuple[int, int]:
    """The best and the worst place that the others leave it with certainty; the same twice where its place is sure."""
    smaller = sum(_below(measured, other, label, joint) for other in labels if other != label)
    larger = sum(_below(measured, label, other, joint) for other in labels if other != label)
    return 1 + smaller, len(labels) - larger


def _below(measured: Figures, one: str, other: str, joint: int) -> bool:
    """Whether one error is smaller than another, with certainty where the trials of both are known."""
    above = measured[one].get("certainly_above")
    if above is not None:
        return other in above[joint]
    return _finite(measured[one]["rms_deg"][joint]) < _finite(measured[other]["rms_deg"][joint])


def _place_words(places: tuple[int, int]) -> str:
    low, high = places
    return str(low) if low == high else f"{low} to {high} (not certain)"


def _over_ppc(measured: Figures, printed: Printed) -> tuple[str, str]:
    """By what factor the error falls from PPC to the proposed law."""
    return _improvement(measured, printed, (PPC,))


def _over_existing(measured: Figures, printed: Printed) -> tuple[str, str]:
    """By what factor it falls from the existing law to the proposed one."""
    return _improvement(measured, printed, (EXISTING, EXISTING + TUNED_SUFFIX))


def _improvement(measured: Figures, printed: Printed, others: Sequence[str]) -> tuple[str, str]:
    good, told = [], []
    for other in others:
        if other not in measured:
            continue
        paper = _ratios(printed.rms_deg[other.removesuffix(TUNED_SUFFIX)], printed.rms_deg[PROPOSED])
        found = _ratios(measured[other]["rms_deg"], measured[PROPOSED]["rms_deg"])
        good += [0.5 <= x / y <= 2.0 for x, y in zip(found, paper, strict=True)]
        told.append(f"{other} / proposed: {_pair(paper)} in the paper, {_pair(found)} here")
    return _grade(good), "; ".join(told) + " (holds: within a factor of 2 of the paper's)"


def _bounded(measured: Figures, printed: Printed) -> tuple[str, str]:
    """The proposed gains do not go on growing: the last quarter of the run has hardly a larger one."""
    law = measured[PROPOSED]
    if law["status"] != "ok":
        share = f"{law['failed']} of {law['trials']} trials" if law.get("trials", 1) > 1 else "the run"
        return BROKEN, f"{share} diverged, the first at {law['end_time']:.3g} s"
    before, last = law["peak_gain_before"], law["peak_gain_last_quarter"]
    good = [b <= 1.1 * a for a, b in zip(before, last, strict=True)]
    return _grade(good), (
        f"largest k̂ {_pair(before)} rad/s² in the first three quarters of the run, {_pair(last)} in the last (holds: "
        "by a tenth larger at most)"
    )


def _chatter(measured: Figures, printed: Printed) -> tuple[str, str]:
    """The proposed law's torque goes up and down less than the existing law's."""
    own = measured[PROPOSED]["torque_variation"]
    good, told = [], [f"torque variation: proposed {_pair(own)} N·m/s"]
    for other in (EXISTING, EXISTING + TUNED_SUFFIX):
        if other in measured:
            theirs = measured[other]["torque_variation"]
            good += [all(_finite(a) < _finite(b) for a, b in zip(own, theirs, strict=True))]
            told.append(f"{other} {_pair(theirs)}")
    return _grade(good), ", ".join(told)


def _adaptation(measured: Figures, printed: Printed) -> tuple[str, str]:
    """The proposed gains rise and fall faster than the existing law's."""
    own = measured[PROPOSED]["gain_times"]
    good, told = [], [f"proposed: {_times(own)}"]
    for other in (EXISTING, EXISTING + TUNED_SUFFIX):
        if other in measured:
            theirs = measured[other]["gain_times"]
            good += [_finite(a) < _finite(b) for a, b in zip(own, theirs, strict=True)]
            told.append(f"{other}: {_times(theirs)}")
    return _grade(good), "; ".join(told)


def _times(times: Sequence[float | None]) -> str:
    up, down = times
    return f"rise from 10 to 90 % of the peak {_seconds(up)}, fall to half of it {_seconds(down)}"


def _seconds(value: float | None) -> str:
    return "never" if value is None else f"{number(value)} s"


def _norm_range(norm: Sequence[float], printed: Printed) -> tuple[str, str]:
    if printed.table == "III":
        return NOT_APPLICABLE, f"not printed for the robot; here {norm[0]:.4f} to {norm[1]:.4f}"
    found = f"{norm[0]:.4f} to {norm[1]:.4f} along the motion of the proposed law, {NORM[0]} to {NORM[1]} in the paper"
    same = [abs(a - b) <= 5e-4 for a, b in zip(norm, NORM, strict=True)]
    return (HOLDS if all(same) else PART if norm[1] < 1.0 else BROKEN), found


_CLAIMS: Mapping[str, Callable[[Figures, Printed], tuple[str, str]]] = {
    "ordering of the controllers: PPC last": _last,
    "ordering of the controllers: proposed first": _first,
    "size of the improvement over PPC": _over_ppc,
    "size of the improvement over the existing law": _over_existing,
    "bounded gains": _bounded,
    "less chatter": _chatter,
    "fast adaptation": _adaptation,
}
CLAIMS = (*_CLAIMS, "norm range")


def _grade(good: Sequence[bool | None]) -> str:
    """The verdict on several parts; None is a part that the trials leave open."""
    return HOLDS if all(good) else BROKEN if all(part is False for part in good) else PART


def _finite(value: float | None) -> float:
    """Of a law that diverged: worse than any other."""
    return math.inf if value is None or math.isnan(value) else value


def _ratios(above: Sequence[float | None], below: Sequence[float | None]) -> list[float]:
    return [_finite(a) / _finite(b) for a, b in zip(above, below, strict=True)]


def _pair(values: Sequence[float | None]) -> str:
    return " and ".join(number(math.nan if x is None else float(x)) for x in values)
