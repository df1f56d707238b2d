"""Files: read within bounds, written whole or not at all, found in a wheel and in a checkout.

Takes paths; gives text, bytes and folders. May import `errors` and `words`.
"""
