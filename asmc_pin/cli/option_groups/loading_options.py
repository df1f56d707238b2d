"""The options that say which arm it is: one list of them for every command that loads an arm.

A new option of `load_arm` is a field of `LoadingOptions` here, a line in `load_keywords`, and a field of the
experiment's `ArmTable`; every command then has it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, TypeAlias

import typer


@dataclass(frozen=True, kw_only=True)
class LoadingOptions:
    """What the command line says about the arm besides its name; None is what was not given."""

    payload: Annotated[
        str | None,
        typer.Option(
            "--payload",
            metavar="KG|LO:HI[@LINK]",
            help="Point mass at a link's frame, or a range of it; default the last moving link.",
        ),
    ] = None
    payload_com: Annotated[
        str | None,
        typer.Option(
            "--payload-com", metavar="X,Y,Z", help="The payload's centre of mass in its link, m; values or ranges."
        ),
    ] = None
    payload_inertia: Annotated[
        str | None,
        typer.Option(
            "--payload-inertia",
            metavar="XX,XY,XZ,YY,YZ,ZZ",
            help="The payload's inertia about its centre, kg·m²; of a range of masses that of the heaviest.",
        ),
    ] = None
    armature: Annotated[
        str | None,
        typer.Option(
            "--armature",
            metavar="A1,LO:HI,…|published",
            help="Reflected rotor inertia per joint, kg·m², values or ranges, or one for all; or what is published.",
        ),
    ] = None
    lock: Annotated[
        list[str] | None,
        typer.Option(
            "--lock",
            metavar="JOINT=ANGLE",
            help="Lock a joint at an angle, rad or m, or all that a pattern such as 'left_*' matches; 'grippers' locks "
            "those of grippers; 'free' frees one. Repeatable.",
        ),
    ] = None
    chain: Annotated[
        str | None,
        typer.Option(
            "--chain", metavar="BASE:TIP", help="Keep the joints between two links; the others are locked near zero."
        ),
    ] = None
    repair: Annotated[
        bool, typer.Option("--repair", help="Take inertia tensors that no rigid body has to the nearest, and say so.")
    ] = False
    gravity: Annotated[
        str | None,
        typer.Option(
            "--gravity", metavar="X,Y,Z", help="Gravity in the base frame, m/s²; 0,0,9.81 hangs it from a ceiling."
        ),
    ] = None
    xacro: Annotated[
        list[str] | None,
        typer.Option("--xacro", metavar="NAME=VALUE", help="An argument of a xacro file. Repeatable."),
    ] = None
    package: Annotated[
        list[str] | None,
        typer.Option("--package", metavar="NAME=DIR", help="Where a ROS package lies that is named. Repeatable."),
    ] = None
    estimate_inertia: Annotated[
        list[str] | None,
        typer.Option(
            "--estimate-inertia",
            metavar="KG|LINK=KG",
            help="Estimate missing inertias from shapes: a mass for all together, or one for each link. Repeatable.",
        ),
    ] = None
    plant: Annotated[
        str | None,
        typer.Option(
            "--plant",
            metavar="FILE",
            help="Payload and armature with their intervals, as 'asmc-pin identify --out FILE' measured them.",
        ),
    ] = None


_Text: TypeAlias = str | None

ONE_VALUE = {
    "payload": Annotated[
        _Text,
        typer.Option(
            "--payload", metavar="KG[@LINK]", help="Point mass at a link's frame; default the last moving link."
        ),
    ],
    "payload_com": Annotated[
        _Text,
        typer.Option("--payload-com", metavar="X,Y,Z", help="The payload's centre of mass in its link, m."),
    ],
    "payload_inertia": Annotated[
        _Text,
        typer.Option(
            "--payload-inertia", metavar="XX,XY,XZ,YY,YZ,ZZ", help="The payload's inertia about its centre, kg·m²."
        ),
    ],
    "armature": Annotated[
        _Text,
        typer.Option(
            "--armature",
            metavar="A1,A2,…|published",
            help="Reflected rotor inertia per joint, kg·m², or one value for all; or what is published.",
        ),
    ],
}
"""The options that take a range elsewhere, of a command where one means nothing."""

NOTHING = LoadingOptions()
"""No option at all."""
