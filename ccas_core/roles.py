"""What layer 2 may know of a rule: the role towards a neighbour, the passing side, the geometry."""

from __future__ import annotations

from enum import StrEnum


class Role(StrEnum):
    """What a ship owes to one neighbour."""

    GIVE_WAY = "give_way"
    STAND_ON = "stand_on"
    BOTH = "both"
    NONE = "none"


class PassingSide(StrEnum):
    """How two ships are to pass one another."""

    PORT_TO_PORT = "port_to_port"
    STARBOARD_TO_STARBOARD = "starboard_to_starboard"
    OVERTAKE_ON_PORT = "overtake_on_port"
    OVERTAKE_ON_STARBOARD = "overtake_on_starboard"
    WINDWARD = "windward"
    ASTERN = "astern"
    EITHER = "either"


class Geometry(StrEnum):
    """How two ships meet."""

    HEAD_ON = "head_on"
    CROSSING = "crossing"
    OVERTAKING = "overtaking"
    NONE = "none"
