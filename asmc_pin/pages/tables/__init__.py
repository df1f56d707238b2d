"""Tables of text, made once for terminal, Markdown, LaTeX and HTML.

Takes figures of trials; gives cells, ranges and marks. May import `metrics`, `results`, `statistics`, and what is open
to all.
"""
