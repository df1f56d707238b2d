"""A proof that M̄ satisfies Lemma 1 over the whole joint box, written to a file and checked by another route."""

import tempfile
from pathlib import Path

import asmc_pin

arm = asmc_pin.load_arm("two_link")
proof = asmc_pin.certify(arm, mbar=0.9 * asmc_pin.design(arm, explain=False).mbar, budget=5.0)
print(proof)

with tempfile.TemporaryDirectory() as folder:
    certificate = proof.save(Path(folder) / "two_link.cert")
    checked = asmc_pin.check(certificate)
print(checked)
assert checked.valid
assert checked.verdict == proof.verdict == "holds"
