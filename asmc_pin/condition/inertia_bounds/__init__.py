"""How large M(q) is over a joint box: proven bounds of its eigenvalues, and of the velocity forces.

Takes an arm, a box and ranges; gives bounds with their hypotheses and a certificate. May import the certificate's
prover, the search and the domain; `checker` derives the same bounds by its own means and imports nothing of this.
"""
