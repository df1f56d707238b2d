"""Small dense algebra, compiled: Cholesky, triangular solves, eigenvalues of matrices of a few rows.

Takes arrays and scratch arrays; gives results in place, without allocation. Imports nothing of the package; the checker
of certificates has arithmetic of its own.
"""
