"""Safety domains: the water around a ship that others keep out of, rectangle, ellipse or dynamic bumper.

A domain is a convex shape about the centre of its ship, told by its *gauge*: how many times the domain
must grow to reach a point.  Gauges are made of `+ - * /`, `abs` and powers alone, so that numbers,
arrays and symbols go through the same formula; whoever draws, measures or controls asks here.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

if TYPE_CHECKING:
    from .frames import FloatArray  # numpy is loaded when an outline is drawn

Number: TypeAlias = Any  # a float, an array of floats, or a symbol of CasADi: whatever can be reckoned with

_OUTLINE: Final = 72  # corners of an outline that is round
_TINY: Final = 1e-12  # keeps the root of a square from an infinite slope at zero


class AbstractDomain(ABC):
    """A safety domain, symmetric to port and starboard."""

    @abstractmethod
    def gauge(self, ahead: Number, aside: Number, speed: Number) -> Number:
        """How many times the domain must grow to reach a point: below 1 inside, 1 on the edge.

        Parameters
        ----------
        ahead, aside
            The point from the centre of the ship, along its course and to starboard [m].
        speed
            Surge speed of the ship [m/s].
        """

    def extent(self, ahead: Number, aside: Number, speed: Number) -> Number:
        """Distance of the edge from the centre, in the direction of a point [m].

        >>> DynamicBumper(length=10.0, full_speed=5.0).extent(1.0, 0.0, 5.0)
        32.0
        """
        return (ahead * ahead + aside * aside) ** 0.5 / self.gauge(ahead, aside, speed)

    def outline(self, speed: float) -> FloatArray:
        """Corners of the domain around the origin, course north, (n, 2), ahead and aside [m]."""
        import numpy as np

        angles = np.linspace(0.0, math.tau, _OUTLINE, endpoint=False)
        ahead, aside = np.cos(angles), np.sin(angles)
        edge: FloatArray = self.extent(ahead, aside, speed)
        return np.column_stack([edge * ahead, edge * aside])


@dataclass(frozen=True, slots=True, kw_only=True)
class Rectangle(AbstractDomain):
    """The safety area of the first paper (Tran et al. 2026, Sec. 5.2): length by breadth."""

    length: float  # [m]
    breadth: float  # [m]

    def gauge(self, ahead: Number, aside: Number, speed: Number) -> Number:  # noqa: ARG002 - the same at any
        """How many times the rectangle must grow."""
        return _greater(abs(ahead) * (2.0 / self.length), abs(aside) * (2.0 / self.breadth))

    def outline(self, speed: float) -> FloatArray:  # noqa: ARG002 - the same at any
        """Its four corners."""
        import numpy as np

        ahead, aside = self.length / 2.0, self.breadth / 2.0
        return np.array([[ahead, aside], [-ahead, aside], [-ahead, -aside], [ahead, -aside]])


@dataclass(frozen=True, slots=True, kw_only=True)
class Ellipse(AbstractDomain):
    """The standard ellipse, with which the bumper is compared (Sec. 4.2 there)."""

    ahead: float  # semi-axis along the course [m]
    aside: float  # semi-axis across it [m]

    def gauge(self, ahead: Number, aside: Number, speed: Number) -> Number:  # noqa: ARG002 - the same at any
        """How many times the ellipse must grow."""
        return _root((ahead / self.ahead) ** 2 + (aside / self.aside) ** 2)


@dataclass(frozen=True, slots=True, kw_only=True)
class DynamicBumper(AbstractDomain):
    """Half an ellipse ahead and half a circle astern, growing with speed (Sec. 3.1 there).

    At rest it is a circle of 0.8 L.  At full speed the half ellipse reaches 3.2 L ahead and the circle 0.8 L;
    between, the reach ahead grows linearly.  The numbers at full speed are half of 6.4 L by 1.6 L, the
    bumper of vessel traffic in narrow channels, of which the printed 0.8 L is the half breadth.

    >>> bumper = DynamicBumper(length=10.0, full_speed=5.0)
    >>> [bumper.extent(1.0, 0.0, u) for u in (0.0, 2.5, 5.0)], bumper.extent(-1.0, 0.0, 5.0)
    ([8.0, 20.0, 32.0], 8.0)
    """

    length: float  # L, of the ship [m]
    full_speed: float  # surge speed at which the domain has its full size [m/s]
    at_rest: float = 0.8  # radius of the circle, and breadth to either side, over L
    at_full_speed: float = 3.2  # reach ahead at full speed, over L

    def reach(self, speed: Number) -> Number:
        """Reach ahead at a surge speed [m]; faster than full speed it grows no more."""
        share = speed / self.full_speed
        share = (1.0 + share - abs(1.0 - share)) / 2.0  # at most 1
        return self.length * (self.at_rest + (self.at_full_speed - self.at_rest) * share)

    def gauge(self, ahead: Number, aside: Number, speed: Number) -> Number:
        """How many times the bumper must grow."""
        before = (ahead + abs(ahead)) / 2.0
        behind = ahead - before
        radius = self.at_rest * self.length
        return _root((before / self.reach(speed)) ** 2 + (behind * behind + aside * aside) / radius**2)


def gap(
    one: AbstractDomain, other: AbstractDomain, *, sight: Number, bearings: tuple[Number, ...], speeds: Number
) -> Number:
    """Distance between two domains on the line that joins their ships [m]; negative where they overlap there.

    Domains that overlap beside this line are not noticed, which the paper says itself of its Eq. (28).

    Parameters
    ----------
    sight
        Distance of the two centres [m].
    bearings
        The other's centre seen from the one, ahead and aside, and the one's seen from the other [m].
    speeds
        Surge speeds of both [m/s].
    """
    ahead, aside, ahead_there, aside_there = bearings
    return sight - one.extent(ahead, aside, speeds[0]) - other.extent(ahead_there, aside_there, speeds[1])


def _greater(one: Number, other: Number) -> Number:
    return (one + other + abs(one - other)) / 2.0


def _root(square: Number) -> Number:
    return (square + _TINY) ** 0.5 if not isinstance(square, float) else math.sqrt(square)
