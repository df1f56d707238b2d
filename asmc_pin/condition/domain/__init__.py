"""Where a condition is asked about: a box of joints, a motion, a recording, ranges of payload and armature.

In come an arm and what the user named; out go boxes, points and variants of the arm. May import `arms` and
`references`.
"""
