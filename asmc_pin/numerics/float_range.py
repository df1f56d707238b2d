"""Between which figures squares and products stay what a float can have."""

from __future__ import annotations

SMALLEST, LARGEST = 1e-50, 1e50
"""Of M̄, K_s and β in SI units."""
