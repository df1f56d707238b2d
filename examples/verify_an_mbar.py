"""May this M̄ be used? A search for a configuration at which Lemma 1 breaks, on an arm with a payload."""

import asmc_pin

arm = asmc_pin.load_arm("ur5", payload=2.0, armature=[0.5, 0.5, 0.3, 0.05, 0.05, 0.05])
print(arm)

report = asmc_pin.verify(arm, mbar=[0.623, 0.877, 0.649, 0.262, 0.208, 0.0198])
print(report)

# A search can refute, never prove: "unrefuted" means that no counter-example was found.
assert report.verdict == "unrefuted"

# Here is a counter-example to a larger M̄, and the norm at it.
too_large = asmc_pin.verify(arm, mbar=2.0 * report.mbar)
print(f"M̄ times 2 is {too_large.verdict} at q = {too_large.worst_q.round(3)}, norm {too_large.lower:.3f}")
print(f"the same by hand: {asmc_pin.lemma1_norm(arm.mass_matrix(too_large.worst_q), too_large.mbar):.3f}")
