"""What a person reads: pages, figures and tables of a comparison, a verdict or a sampled loop, written offline.

In come results and reports, out go HTML, PDF, PNG, Markdown and LaTeX. May import what makes those reports, and
`viewer`; steps no dynamics.
"""
