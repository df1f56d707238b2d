"""The replay: every cell's bound again, from the inequality in docs/certificate.md.

Takes a chain, statements and a record of bisections; gives whether each statement follows. Imports of the checker
alone.
"""
