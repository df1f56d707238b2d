"""The compiled recursions over a tree of links: mass matrices of many configurations, placement, gradients.

Takes the `Tree` of an arm and joint values; gives M(q) and what its gradient needs. May import `numerics`, typing and
errors: what computes in it is numba, and Pinocchio is what it is held against.
"""
