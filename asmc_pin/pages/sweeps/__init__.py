"""Pages of a sweep: how figures are distributed over the trials, where controllers fail, and who is better.

In come the findings of a sweep, out go Markdown, figures and HTML. May import what `pages` may.
"""
