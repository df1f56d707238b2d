"""A search and a proof in one report: the proof's bounds, the worst that either saw, and no claim beyond either."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from asmc_pin import load_arm, verify
from asmc_pin.arms import Arm
from asmc_pin.condition.certificate import CertificateResult, certify
from asmc_pin.condition.certificate.search_and_proof import certified
from asmc_pin.errors import ParameterError
from asmc_pin.pages.condition_words import sentence


@pytest.fixture(scope="module")
def arm() -> Arm:
    return load_arm("two_link")


@pytest.fixture(scope="module")
def proof(arm: Arm) -> CertificateResult:
    return certify(arm, 0.01, budget=10.0, threads=1)


def test_a_proven_mbar_holds_with_a_bound_above_all_that_was_seen(arm: Arm, proof: CertificateResult) -> None:
    report = certified(verify(arm, 0.01), proof)
    assert (report.verdict, report.kind) == ("holds", "certified")
    assert report.upper is not None
    assert 0.98860009 <= report.lower <= report.upper <= 1.0
    assert not any("never prove" in note for note in report.notes)
    assert len({note[:20] for note in report.notes}) == len(report.notes)
    content = json.loads(json.dumps(report.to_json_dict(), allow_nan=False))
    assert content["scale_proven"] >= 1.0
    assert content["scale_refuted"] > content["scale_proven"]


def test_what_is_printed_is_no_more_than_what_is_proven(arm: Arm, proof: CertificateResult) -> None:
    report = certified(verify(arm, 0.01, samples=64), proof)
    # The nearest six digits would be 0.995123 and 2.71829, which nobody proved.
    odd = replace(report, upper=0.99512345, scale_proven=2.71828777, scale_refuted=2.72000012)
    said = "\n".join(odd.lines())
    assert "at most 0.995124 " in said
    assert "proven for M̄ times 2.71828," in said
    assert "counter-example for M̄ times 2.72001 " in said
    assert "at most 0.995124." in sentence(odd)


def test_a_counter_example_outweighs_a_proof(arm: Arm, proof: CertificateResult) -> None:
    found = verify(arm, 0.01, samples=64)
    report = certified(replace(found, lower=1.5), proof)
    assert (report.verdict, report.upper) == ("violated", None)
    assert report.scale_refuted is not None
    assert report.scale_refuted <= 1.0


def test_proofs_of_something_else_are_refused(arm: Arm, proof: CertificateResult) -> None:
    for other in (verify(arm, 0.02, samples=64), verify(arm, 0.01, condition="weighted", samples=64)):
        with pytest.raises(ParameterError, match="not of the same"):
            certified(other, proof)
