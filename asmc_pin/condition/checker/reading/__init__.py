"""What stands in a certificate, read by the checker's own means: the header's schema, the URDF's text, the chain.

Takes bytes; gives checked contents and a chain rounded once from exact decimals. May import the reader of the container
and what is open to all.
"""
