"""The proof of one statement over one box, compiled: articulated recursions, losses and the tree of bisections.

Takes a problem's arrays and a box; gives whether it holds there, and how near it was. Everything is numba; the theorem
is in docs/certificate.md. May import `numerics`.
"""
