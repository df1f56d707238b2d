"""Proofs of the frozen sampled loop: over a joint box, and about rest under gravity.

Takes an arm and the plain loop; gives what is proven, with a certificate. May import `condition` and the loop's
parameters; the checker derives the same by its own means.
"""
