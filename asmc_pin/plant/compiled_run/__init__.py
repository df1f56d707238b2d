"""Runs trial by trial in compiled code: chunks of ticks of one trial after the other, its state in the cache all along.

Takes a plant's numbers as rows, a compiled law or its commands, and ticks; gives histories. May import
`controllers.one_trial`, `rigid_body`, `numerics`, and of the plant what is compiled for one trial.
"""
