"""A border drawn through an encounter: where the ships are on their way, and in any direction."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

import numpy as np

from ..frames import PathPose
from ..regions import Region
from ..sim.scenario import Scenario
from ..waterway import guiding_line
from .draw import undisturbed_meeting

BEYOND: Final = 1.3  # the border is met no later than so many times the time to the meeting
_FAR: Final = 30_000.0  # extent of the region beyond the border [m]


def with_border(
    rng: np.random.Generator, drawn: Scenario, ruleset: str, *, lacking: bool = False
) -> Scenario:
    """Put all waters on one side of a straight line under another ruleset.

    The line passes through a point that one of the two ships, undisturbed, comes to between its start and a
    while after the meeting; its direction is uniform, so that some ships sail along it.  Where one is
    `lacking`, the first ship has not got that ruleset.
    """
    met = undisturbed_meeting(drawn)
    plan = drawn.ships[int(rng.integers(len(drawn.ships)))]
    frame = guiding_line(drawn.waters, plan.route).frame
    sailed = plan.speed * float(rng.uniform(0.0, BEYOND * met.time))
    at = frame.to_ned(PathPose(frame.to_path(plan.start).x + sailed, 0.0, 0.0))
    angle = float(rng.uniform(-math.pi, math.pi))
    along = np.array([math.cos(angle), math.sin(angle)]) * _FAR
    across = np.array([-along[1], along[0]])
    here = np.array([at.x, at.y])
    corners = np.round([here - along, here + along, here + along + across, here - along + across], 3) + 0.0
    region = Region(id="beyond", ruleset=ruleset, polygon=corners)
    first, *others = drawn.ships
    aboard = (drawn.waters.ruleset,) if lacking else ()
    waters = replace(drawn.waters, regions=(region,))
    return replace(drawn, waters=waters, ships=(replace(first, rulesets=aboard), *others))
