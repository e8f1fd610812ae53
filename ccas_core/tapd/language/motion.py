"""Quantities of two moving ships, compared with a limit: each becomes signs of polynomials.

With r the other's position less own, w the other's velocity less own, both at constant velocity, and
a x b = a_north b_east - a_east b_north (positive where b lies clockwise of a):

    TCPA  = - r.w / w.w                           time to the closest point of approach
    DCPA  = |r x w| / |w|                         distance there; |r| where w = 0
    angle = atan2(a x b, a.b)                     between two vectors, clockwise from the first

No division, root or arc tangent is left, so that the sign can be decided exactly, and proved about.  An
angle enters by its tangent, rounded once to a fraction (`tangent`): that fraction is the definition.
TCPA without relative motion is never; an angle at a ship at rest is 0, for it has no course.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Final, TypeAlias

from .formula import NEGATIVE, POSITIVE, ZERO, Formula, all_of, any_of, negated, sign
from .polynomial import Polynomial, number, variable

Vector: TypeAlias = tuple[Polynomial, Polynomial]  # north, east
Limit: TypeAlias = Polynomial
Exceeds: TypeAlias = Callable[[Limit], Formula]

R: Final[Vector] = (variable("rx"), variable("ry"))
W: Final[Vector] = (variable("wx"), variable("wy"))
VELOCITY: Final[dict[str, Vector]] = {
    "own": (variable("ovx"), variable("ovy")),
    "other": (variable("tvx"), variable("tvy")),
}
_TANGENT_DENOMINATOR: Final = 10**6


def dot(a: Vector, b: Vector) -> Polynomial:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1]


def cross(a: Vector, b: Vector) -> Polynomial:
    """Vector product: positive where b lies clockwise of a."""
    return a[0] * b[1] - a[1] * b[0]


def line_of_sight(ship: str) -> Vector:
    """Position of the other of two ships, seen from `ship`."""
    return R if ship == "own" else (-R[0], -R[1])


@dataclass(frozen=True, slots=True)
class Quantity:
    """A quantity that can be compared with a limit: when it is greater, and when it is at least as great."""

    above: Exceeds
    at_least: Exceeds


def compared(quantity: Quantity, relation: str, limit: Limit) -> Formula:
    """`quantity relation limit`, for the relations <, <=, >, >=."""
    exceeds = quantity.above if relation in (">", "<=") else quantity.at_least
    found = exceeds(limit)
    return found if relation in (">", ">=") else negated(found)


def _positive(polynomial: Polynomial) -> Formula:
    return sign(polynomial, POSITIVE)


def _not_negative(polynomial: Polynomial) -> Formula:
    return sign(polynomial, ZERO, POSITIVE)


def tcpa() -> Quantity:
    """Time to the closest point of approach [s]; past where negative, never where nothing moves."""
    closing, square = -dot(R, W), dot(W, W)

    def above(limit: Limit) -> Formula:
        return any_of([sign(square, ZERO), _positive(closing - limit * square)])

    return Quantity(above=above, at_least=lambda limit: _not_negative(closing - limit * square))


def _by_squares(square: Callable[[Limit], tuple[Polynomial, Polynomial]]) -> Quantity:
    """A length whose square is known, as a fraction: |q| > limit where numerator > limit^2 denominator."""

    def beyond(limit: Limit, decide: Exceeds) -> Formula:
        numerator, denominator = square(limit)
        further = decide(numerator - limit * limit * denominator)
        return any_of([sign(limit, NEGATIVE), further])  # no length is less than a negative one

    return Quantity(
        above=lambda limit: beyond(limit, _positive),
        at_least=lambda limit: beyond(limit, _not_negative),
    )


def distance() -> Quantity:
    """Distance between the ships [m]."""
    return _by_squares(lambda _: (dot(R, R), number(1)))


def speed(ship: str) -> Quantity:
    """Speed of one of the ships [m/s]."""
    velocity = VELOCITY[ship]
    return _by_squares(lambda _: (dot(velocity, velocity), number(1)))


def dcpa() -> Quantity:
    """Distance at the closest point of approach [m]."""
    moving = _by_squares(lambda _: (cross(R, W) * cross(R, W), dot(W, W)))
    still = distance()

    def either(one: Exceeds, other: Exceeds) -> Exceeds:
        rest = sign(dot(W, W), ZERO)
        return lambda limit: any_of([all_of([rest, other(limit)]), all_of([negated(rest), one(limit)])])

    return Quantity(above=either(moving.above, still.above), at_least=either(moving.at_least, still.at_least))


def tangent(angle: Fraction) -> Fraction:
    """Tangent of an acute angle [deg], as the fraction that defines the limit.

    >>> tangent(Fraction(45))
    Fraction(1, 1)
    """
    return Fraction(math.tan(math.radians(float(angle)))).limit_denominator(_TANGENT_DENOMINATOR)


@dataclass(frozen=True, slots=True)
class AngleLimit:
    """A limit [deg], and the tangent of its acute part, which is a parameter where the limit is one."""

    degrees: Fraction
    tangent: Polynomial  # of |degrees|, or of 180 - |degrees| where that is acute; unused at 0, 90 and 180


def angle_beyond(a: Vector, b: Vector, limit: AngleLimit, *, strict: bool) -> Formula:
    """Whether the angle between two vectors, 0 to 180 deg, is greater than a limit (or equal)."""
    along, across = dot(a, b), cross(a, b)
    decide = _positive if strict else _not_negative
    degrees = limit.degrees
    if degrees < 0 or (degrees == 0 and not strict):
        return sign(number(1), POSITIVE)
    if degrees > 180:
        return sign(number(1), NEGATIVE)
    if degrees in (0, 180):
        sides = sign(across, NEGATIVE, POSITIVE)
        astern = all_of([sign(across, ZERO), sign(along, NEGATIVE)])
        if degrees == 0:
            return any_of([sides, astern])
        return sign(number(1), NEGATIVE) if strict else astern
    if degrees == 90:
        return sign(along, NEGATIVE) if strict else all_of([sign(along, NEGATIVE, ZERO), _moves(a, b)])
    if degrees < 90:
        wide = [decide(across - limit.tangent * along), decide(-across - limit.tangent * along)]
        return all_of([any_of([sign(along, NEGATIVE), *wide]), _moves(a, b)])
    behind = -limit.tangent * along
    return all_of([sign(along, NEGATIVE), decide(behind - across), decide(behind + across)])


def _moves(a: Vector, b: Vector) -> Formula:
    """Neither vector is zero, as far as an angle between them has a meaning."""
    return any_of([sign(dot(a, b), NEGATIVE, POSITIVE), sign(cross(a, b), NEGATIVE, POSITIVE)])


def turned_beyond(a: Vector, b: Vector, limit: AngleLimit, *, strict: bool) -> Formula:
    """Whether the angle from one vector to another, -180 to 180 deg clockwise, is greater (or equal)."""
    along, across = dot(a, b), cross(a, b)
    starboard = any_of([_positive(across), all_of([sign(across, ZERO), sign(along, NEGATIVE)])])
    if limit.degrees > 0 or (limit.degrees == 0 and strict):
        beyond = angle_beyond(a, b, limit, strict=strict)
        return all_of([starboard, beyond])
    if limit.degrees == 0:
        return _not_negative(across)
    mirror = AngleLimit(-limit.degrees, limit.tangent)
    return any_of([starboard, negated(angle_beyond(a, b, mirror, strict=not strict))])


def from_starboard(own: str, other: str) -> Formula:
    """Whether the course of `other` crosses that of `own` from starboard to port; antisymmetric."""
    return sign(cross(VELOCITY[own], VELOCITY[other]), NEGATIVE)


def closing() -> Formula:
    """Whether the ships come nearer."""
    return sign(dot(R, W), NEGATIVE)
