"""Units at the edges, as numbers in SI: inside, all is metres, seconds, radians, kilograms."""

from __future__ import annotations

import math
from typing import Final

DEGREE: Final = math.pi / 180.0  # [rad]
KNOT: Final = 1852.0 / 3600.0  # [m/s]
KILOMETRE_PER_HOUR: Final = 1000.0 / 3600.0  # [m/s]
TONNE: Final = 1000.0  # [kg]
MINUTE: Final = 60.0  # [s]
HOUR: Final = 3600.0  # [s]
KILOMETRE: Final = 1000.0  # [m]
NAUTICAL_MILE: Final = 1852.0  # [m]


def wrap(angle: float) -> float:
    """Bring an angle [rad] into (-pi, pi].

    >>> wrap(3 * math.pi) == math.pi
    True
    >>> round(wrap(-3.5), 4)
    2.7832
    """
    wrapped = math.remainder(angle, 2.0 * math.pi)
    return math.pi if wrapped == -math.pi else wrapped
