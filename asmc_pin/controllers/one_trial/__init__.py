"""A law's step for one trial, compiled: what the engine runs tick by tick, and `step` over the rows of a batch.

Takes a function of one trial with a law's numbers as rows; gives what both of them call. May import numpy, numba,
`numerics`, `parameters` and what is open to all.
"""
