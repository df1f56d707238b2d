"""Motion in the browser: Meshcat scenes in one page that opens offline, or is served to this machine alone.

Takes an arm and recorded motions; gives pages. May import `arms`, `experiment`, `metrics` and `results`; steps no
dynamics.
"""

from asmc_pin.viewer.colours import controller_colors
from asmc_pin.viewer.drawing.drawn_bodies import DrawnArm, draw
from asmc_pin.viewer.drawing.link_shapes import link_shapes
from asmc_pin.viewer.drawing.marks import Mark, ball, with_marks
from asmc_pin.viewer.drawing.skeleton import rod
from asmc_pin.viewer.local_server import make_server, serve
from asmc_pin.viewer.played_motion import PlayedMotion, describe
from asmc_pin.viewer.player_page import player_scripts, replay_element, replay_page, static
from asmc_pin.viewer.result_replay import replay_fragment, replay_html, write_replay
from asmc_pin.viewer.time_marks import TimeMark

__all__ = [
    "DrawnArm",
    "Mark",
    "PlayedMotion",
    "TimeMark",
    "ball",
    "controller_colors",
    "describe",
    "draw",
    "link_shapes",
    "make_server",
    "player_scripts",
    "replay_element",
    "replay_fragment",
    "replay_html",
    "replay_page",
    "rod",
    "serve",
    "static",
    "with_marks",
    "write_replay",
]
