"""The worst configuration that can be found: samples, climbs, maps over two joints.

Takes an arm, M̄ and a domain; gives the largest value seen and where. A search proves nothing; only what it refutes is
certain. May import `norm`, `domain` and the rooms that they may.
"""
