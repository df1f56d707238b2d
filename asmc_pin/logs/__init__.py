"""What a robot recorded: tables of any common form, their joints' columns, and rows made regular.

Takes a file, the joints' names and options; gives a `JointLog` and what was found wrong with it. May import what is
open to all: a log knows no arm.
"""

from __future__ import annotations

from asmc_pin.logs.joint_log import JointLog, read_log
from asmc_pin.logs.log_options import LogOptions

__all__ = ["JointLog", "LogOptions", "read_log"]
