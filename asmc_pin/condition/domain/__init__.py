"""Where a condition is asked about: a box of joints, a motion, a recording, ranges of payload and armature.

Takes an arm and what the user named; gives boxes, points and variants of the arm. May import `arms` and `references`.
"""
