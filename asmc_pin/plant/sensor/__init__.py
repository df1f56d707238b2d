"""What a drive reports: quantised and noisy angles and velocities. Parameters, running state, noise of a trial.

Takes the true state; gives a `Sample`'s content. May import `parameters` and what is open to all.
"""
