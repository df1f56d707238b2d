"""Proofs of a condition over a joint box: `certify`. The algorithm and why it is sound: docs/certificate.md."""

from asmc_pin.condition.certificate.certify import certify
from asmc_pin.condition.certificate.result import CertificateResult
from asmc_pin.condition.certificate.strategy import ProofProgress

__all__ = ["CertificateResult", "ProofProgress", "certify"]
