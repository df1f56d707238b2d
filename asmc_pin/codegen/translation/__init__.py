"""From a law's step in Python to C99: a strict translator of the few words that such a step is written in.

Takes a `TrialStep`; gives the same operations in the same order as static C functions, or says what it does not know.
May import `controllers.one_trial`, `parameters` and what is open to all.
"""
