"""Where an arm's description and the files that it names come from: packages, meshes, names of other collections.

Takes names and paths; gives files that are there, read within bounds. May import what is open to all, and nothing of
Pinocchio.
"""
