"""The best M̄ for an arm: a convex program over sampled M(q), exchanged with searches for what it missed.

Takes an arm and a domain; gives a `DesignReport`. May import `search` and the rooms that it may; cvxpy lives here.
"""
