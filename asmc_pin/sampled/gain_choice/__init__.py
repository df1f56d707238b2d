"""Gains and a scale of M̄ for an arm, with margins that hold where they were searched.

Takes an arm with its ranges, M̄, a period and the margins asked for; gives a `GainDesign`. May import the rest of
`sampled` and what it may.
"""
