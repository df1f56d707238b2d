"""Pages of a sweep: how figures are distributed over the trials, where controllers fail, and who is better.

Takes the findings of a sweep; gives Markdown, figures and HTML. May import what `pages` may.
"""
