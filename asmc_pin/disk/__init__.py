"""Files: read within bounds, written whole or not at all, found in a wheel and in a checkout.

In come paths, out go text, bytes and folders. May import `errors` and `words`.
"""
