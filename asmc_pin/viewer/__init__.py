"""Motion in the browser: Meshcat scenes in one page that opens offline, or is served to this machine alone.

In come an arm and recorded motions, out go pages. May import `arms`, `experiment`, `metrics` and `results`; steps no
dynamics.
"""

from asmc_pin.viewer.colours import controller_colors
from asmc_pin.viewer.drawing.drawn_bodies import DrawnArm, draw
from asmc_pin.viewer.local_server import make_server, serve
from asmc_pin.viewer.played_motion import PlayedMotion, describe
from asmc_pin.viewer.player_page import player_scripts, replay_element, replay_page, static
from asmc_pin.viewer.result_replay import replay_fragment, replay_html, write_replay

__all__ = [
    "DrawnArm",
    "PlayedMotion",
    "controller_colors",
    "describe",
    "draw",
    "make_server",
    "player_scripts",
    "replay_element",
    "replay_fragment",
    "replay_html",
    "replay_page",
    "serve",
    "static",
    "write_replay",
]
