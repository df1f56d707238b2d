"""The rigid bodies that move: links merged over fixed and locked joints, judged, and repaired on request.

Takes a checked URDF and Pinocchio's model of it; gives bodies, what is wrong with them, and a repaired URDF. May import
`arms.urdf` and what is open to all.
"""
