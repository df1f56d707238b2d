"""Proofs of a condition over a joint box: `certify`. The algorithm and why it is sound: docs/certificate.md.

Takes an arm, M̄ and ranges; gives a certificate or a counter-example. May import `norm`, `search`, `domain` and the
rooms that they may, never `checker`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from asmc_pin.lazy import load_on_first_use

if TYPE_CHECKING:
    from asmc_pin.condition.certificate.certificate_result import CertificateResult as CertificateResult
    from asmc_pin.condition.certificate.proof_progress import ProofProgress as ProofProgress
    from asmc_pin.condition.certificate.proving import certify as certify

__getattr__, __dir__, __all__ = load_on_first_use(__name__)
