"""A page to explore the condition with: joints and M̄ under the hand, all figures at once; offline, or served here.

Takes an arm and M̄; gives a page that computes in the browser. May import `arms`, `condition`, `rigid_body`, `viewer`
and `pages`; coal lives here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from asmc_pin.lazy import load_on_first_use

if TYPE_CHECKING:
    from asmc_pin.exploring.exploring_verb import explore as explore

__getattr__, __dir__, __all__ = load_on_first_use(__name__)
