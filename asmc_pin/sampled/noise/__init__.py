"""What a drive's sensors do to the sampled loop: torque and error of their noise, and what would lessen it.

Takes a loop, frozen arms and how angles and velocities are measured; gives RMS values, bounds and advice. May import
the rest of `sampled` and what it may.
"""
