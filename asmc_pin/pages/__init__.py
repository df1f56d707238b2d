"""What a person reads: pages, figures and tables of a comparison, a verdict or a sampled loop, written offline.

Takes results and reports; gives HTML, PDF, PNG, Markdown and LaTeX. May import what makes those reports, and `viewer`;
steps no dynamics.
"""
