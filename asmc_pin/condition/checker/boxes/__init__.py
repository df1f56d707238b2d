"""The replay: every cell's bound again, from the inequality in docs/certificate.md.

In come a chain, statements and a record of bisections; out goes whether each statement follows. Imports of the checker
alone.
"""
