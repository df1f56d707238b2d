"""Pages of a benchmark: performance profiles, ranks with intervals, who fails where, and the proposed law among them.

Takes the findings of a benchmark; gives Markdown, figures and HTML. May import what `pages` may.
"""
