"""Runs trial by trial in compiled code: chunks of ticks of one trial after the other, its state in the cache all along.

In come a plant's numbers as rows, a compiled law or its commands, and ticks; out come histories. May import
`controllers.one_trial`, `rigid_body`, `numerics`, and of the plant what is compiled for one trial.
"""
