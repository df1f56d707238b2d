"""What a drive reports: quantised and noisy angles and velocities. Parameters, running state, noise of a trial.

In comes the true state, out goes a `Sample`'s content. May import `parameters` and what is open to all.
"""
