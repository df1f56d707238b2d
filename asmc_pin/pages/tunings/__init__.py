"""Pages of a tuning: how gains were found, what they cost in chatter, and how they did on draws that were held out.

Takes the findings of a tuning; gives Markdown, figures and HTML. May import what `pages` may.
"""
