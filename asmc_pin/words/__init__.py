"""Words and numbers for people: signs escaped once for each medium, figures rounded safely, units asked about.

In come values, out goes text. May import `errors`.
"""
