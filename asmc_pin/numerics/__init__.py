"""Small dense algebra, compiled: Cholesky, triangular solves, eigenvalues of matrices of a few rows.

In come arrays and scratch arrays, out go results in place, without allocation. Imports nothing of the package; the
checker of certificates has arithmetic of its own.
"""
