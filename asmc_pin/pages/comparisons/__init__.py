"""Parts of a comparison's page and figures: panels, the figures for a paper, and where a result comes from.

Takes a result or its trajectories; gives HTML and panels. May import what `pages` may.
"""
