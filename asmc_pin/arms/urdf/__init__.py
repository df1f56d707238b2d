"""A URDF as text and as a tree of joints: reading, checking, merging fixed links.

Takes XML of any quality; gives a checked structure with inertias as they move, or one message that says what is wrong.
May import `rigid_body` and what is open to all, and nothing of Pinocchio.
"""
