"""Tables of text, made once for terminal, Markdown, LaTeX and HTML.

In come figures of trials, out go cells, ranges and marks. May import `metrics`, `results`, `statistics`, and what is
open to all.
"""
