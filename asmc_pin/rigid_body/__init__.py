"""The compiled recursions over a tree of links: mass matrices of many configurations, placement, gradients.

In comes the `Tree` of an arm and joint values; out go M(q) and what its gradient needs. May import `numerics`,
typing and errors: what computes in it is numba, and Pinocchio is what it is held against.
"""
