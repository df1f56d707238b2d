"""The two conditions on M̄ at given mass matrices: Lemma 1's norm and the weighted one, in numpy and compiled.

Takes M and M̄; gives norms and gradients. May import `rigid_body` and `numerics`.
"""
