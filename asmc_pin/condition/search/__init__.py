"""The worst configuration that can be found: samples, climbs, maps over two joints.

In come an arm, M̄ and a domain; out go the largest value seen and where. A search proves nothing; only what it refutes
is certain. May import `norm`, `domain` and the rooms that they may.
"""
