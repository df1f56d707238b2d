"""Words and numbers for people: signs escaped once for each medium, figures rounded safely, units asked about.

Takes values; gives text. May import `errors`.
"""
