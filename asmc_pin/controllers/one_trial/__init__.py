"""A law's step for one trial, compiled: what the engine runs tick by tick, and `step` over the rows of a batch.

In comes a function of one trial with a law's numbers as rows, out goes what both of them call. May import numpy,
numba, `numerics`, `parameters` and what is open to all.
"""
