"""Advice that several rooms give, in one wording."""

MBAR_REMEDY = "ask 'asmc-pin design' for an M̄ that suits M(q)"
"""Where Lemma 1 is broken, and where M̄ is too large for any gains."""
