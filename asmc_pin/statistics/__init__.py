"""How sure a comparison is: intervals, tests, ranks and profiles of figures that are paired trial by trial.

Takes figures of trials and tasks, with +∞ for a failure; gives medians, ratios with intervals, and probabilities. Plain
numpy and scipy: may import what is open to all, and is read by tables, pages and studies alike.
"""
