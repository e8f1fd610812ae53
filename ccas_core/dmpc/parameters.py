"""The numbers of layer 2, each with its place in the paper, and the two profiles of Sec. 5.

Printed: Table 1 and Sec. 5.1, 5.2 (T_1, chi_max, delta T, y_max, K_y, K_s, K_d, beta, iter_max, N).
Found by `studies/find_parameters.py`, because the paper does not print them: all others.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Final

from ..roles import Geometry


class Wait(StrEnum):
    """The two readings of wait(i) in Algorithm 2."""

    INTERLEAVED = "interleaved"  # within an iteration, a ship waits for its predecessors
    SEQUENTIAL = "sequential"  # predecessors finish all their iterations first (TAPD step 5)


class RiskShape(StrEnum):
    """How the risk ellipse of Eq. (6) lies."""

    COURSE_ALIGNED = "course_aligned"  # along the other ship's course, sized by both hulls
    AXIS_BOUND = "axis_bound"  # as printed: along the own ship's axes
    FITTED = "fitted"  # around both hulls and the way that they make in a step, for any relative course


class Anchor(StrEnum):
    """The trajectory that a period's negotiation begins with: p and the broadcast of Algorithm 2's input."""

    LAST = "last"  # the last plan, shifted by a period
    NOMINAL = "nominal"  # on along the guiding line at nominal speed


class Expectation(StrEnum):
    """What a ship expects of one that has not yet told its intention in this period (steps 6 to 9)."""

    LAST_PLAN = "last_plan"  # its promise of the last period, shifted
    PREDICTION = "prediction"  # constant velocity


class Start(StrEnum):
    """Guesses from which a local problem is solved; the best answer wins, the first on a tie."""

    LAST = "last"  # the last plan, shifted by a period
    NOMINAL = "nominal"  # no offset, full speed
    STARBOARD = "starboard"  # half the room to starboard
    SLOW = "slow"  # no offset, a third of the speed


@dataclass(frozen=True, slots=True, kw_only=True)
class Weights:
    """Weights of the cost, Eq. (6) to (9).  Costs have no unit."""

    K_ca: float = 1500.0  # height of the collision risk
    K_d: float = 5.0  # discount of the risk per step
    K_y: float = 1e-2  # change of offset [1/m^2]
    K_s: float = 2e-2  # change of speed
    mu_1: float = 0.11  # B_1 of the speed factor
    mu_2: float = 1.0  # B_1 of the offset
    mu_3: float = 0.003  # r_1 of B_2 [1/m]
    r_2: float = 0.0  # r_2 of B_2 [m]
    side: float = 1.0  # side that B_2 leaves free: 1 starboard, -1 port
    gamma_s: float = 0.0082  # width of B_1 of the speed factor
    gamma_y: float = 1.04  # width of B_1 of the offset [m^2]


@dataclass(frozen=True, slots=True, kw_only=True)
class Risk:
    """Shape of the collision risk, Eq. (6)."""

    shape: RiskShape = RiskShape.COURSE_ALIGNED
    kappa_along: float = 0.8  # semi-axis over the sum of half-lengths along the other's course
    kappa_across: float = 1.37  # the same, across it
    alpha_x: float = 82.0**2  # of the printed form [m^2]
    alpha_y: float = 19.6**2  # of the printed form [m^2]


@dataclass(frozen=True, slots=True, kw_only=True)
class Kinematics:
    """Constants of the model, Eq. (4)."""

    time_step: float = 20.0  # delta T [s]
    time_constant: float = 28.458  # T_1 [s]
    course_limit: float = math.pi / 6.0  # chi_max [rad]
    steering_gain: float = 0.02  # K_e [1/m]


@dataclass(frozen=True, slots=True, kw_only=True)
class Roles:
    """How much a role weighs, and when it is fulfilled.  No number here depends on a ruleset."""

    give_way: float = 5.0  # factor of K_ca towards a ship to which the own ship gives way, or that failed to
    stand_on: float = 0.05  # the same, towards a ship that keeps clear
    none: float = 1.0  # the same, towards others
    steadiness: float = 5.0  # factor of mu_1, mu_2 of a ship that stands on
    act_within: float = 15.0  # a ship acts if its line leads nearer than this to a safety area [m]
    resume_beyond: float = 20.0  # and returns to its line if that leads no nearer than this [m]
    clear_by: float = 5.0  # a plan that stays so far from all safety areas clears [m]
    visible_offset: float = 12.0  # least offset of a ship that gives way to one side [m]
    visible_factor: float = 0.8  # greatest speed factor with which it begins to give way by speed
    swing: float = 0.15  # share of the length by which a ship needs more water than its beam to go aside
    reserve: float = 2  # periods that a ship that stands on keeps in hand before it acts
    patience: float = 8  # periods lost after which a ship goes on as soon as its line clears by `clear_by`
    crossing: Weights = field(
        default_factory=lambda: Weights(K_y=5.0, K_s=5.0, mu_1=1.0)
    )  # in place of `Settings.weights`


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Everything a ship's controller is set to.  Frozen: a change is `dataclasses.replace`."""

    weights: Weights = field(default_factory=Weights)
    risk: Risk = field(default_factory=Risk)
    kinematics: Kinematics = field(default_factory=Kinematics)
    horizon: int = 45  # N
    iterations: int = 3  # iter_max
    beta: float = 3e-4  # penalty [1/m^2]
    relaxation: float = 1.0  # lambda
    wait: Wait = Wait.SEQUENTIAL
    starts: tuple[Start, ...] = (Start.LAST,)
    anchor: Anchor = Anchor.LAST
    expectation: Expectation = Expectation.LAST_PLAN
    roles: Roles | None = None  # None: the paper's controller, which knows no roles

    def __post_init__(self) -> None:
        if not 0.0 < self.relaxation < 2.0:
            raise ValueError(f"lambda must lie in (0, 2) (Theorem 1), got {self.relaxation}")
        if not self.beta > 0.0:
            raise ValueError(f"beta must be positive (Theorem 1), got {self.beta}")
        if self.horizon < 1 or self.iterations < 1:
            raise ValueError("horizon and iterations must be at least 1")


HEAD_ON: Final = Settings(
    weights=Weights(K_ca=900.0, mu_2=4.16),
    risk=Risk(kappa_across=0.9),
    starts=(Start.LAST, Start.STARBOARD),
)
CROSSING: Final = Settings(weights=Weights(K_y=5.0), starts=(Start.LAST, Start.NOMINAL))
PROFILES: Final = {Geometry.HEAD_ON: HEAD_ON, Geometry.OVERTAKING: HEAD_ON, Geometry.CROSSING: CROSSING}
FAITHFUL: Final = Settings(
    weights=Weights(K_ca=900.0, K_s=1.0, mu_1=5.0, mu_2=20.0),
    risk=Risk(shape=RiskShape.FITTED, kappa_along=0.8, kappa_across=0.8),
    roles=Roles(),
)
"""The default for all waters: roles towards each neighbour, profile by the encounters at hand."""


def blended(one: Weights, other: Weights, share: float) -> Weights:
    """Go over from one set of weights to another: positive weights by their logarithms.

    >>> blended(Weights(K_y=0.01), Weights(K_y=1.0), 0.5).K_y
    0.1
    """
    values = {}
    for name in Weights.__dataclass_fields__:
        a, b = getattr(one, name), getattr(other, name)
        values[name] = a ** (1.0 - share) * b**share if a > 0.0 and b > 0.0 else a + share * (b - a)
    return Weights(**values)


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number that a scenario may set: where it lives, its unit, its range, its meaning."""

    group: str  # field of `Settings` that holds it, or "" for `Settings` itself
    name: str  # field there
    unit: str  # as files write it; "" for a bare number: a weight's own unit stands in its meaning
    low: float
    high: float
    meaning: str


def _weight(name: str, meaning: str) -> Parameter:
    return Parameter("weights", name, "", 0.0, 1e9, meaning)


def _role(name: str, unit: str, meaning: str) -> Parameter:
    return Parameter("roles", name, unit, 0.0, 1e3, meaning)


PARAMETERS: Final[dict[str, Parameter]] = {
    "K_ca": _weight("K_ca", "height of the collision risk"),
    "K_d": _weight("K_d", "discount of the risk per step"),
    "K_y": _weight("K_y", "weight of a change of offset [1/m^2]"),
    "K_s": _weight("K_s", "weight of a change of speed factor [1]"),
    "mu_1": _weight("mu_1", "weight of B_1 of the speed factor"),
    "mu_2": _weight("mu_2", "weight of B_1 of the offset"),
    "mu_3": _weight("mu_3", "weight of B_2, the penalty on turns to port [1/m]"),
    "r_2": Parameter("weights", "r_2", "", -1e3, 1e3, "shift of B_2 [m]"),
    "gamma_s": Parameter("weights", "gamma_s", "", 1e-9, 1e9, "width of B_1 of the speed factor"),
    "gamma_y": Parameter("weights", "gamma_y", "", 1e-9, 1e9, "width of B_1 of the offset [m^2]"),
    "kappa_along": Parameter("risk", "kappa_along", "", 1e-3, 1e3, "risk ellipse along the other's course"),
    "kappa_across": Parameter(
        "risk", "kappa_across", "", 1e-3, 1e3, "risk ellipse across the other's course"
    ),
    "alpha_x": Parameter("risk", "alpha_x", "m2", 1e-3, 1e9, "printed risk ellipse along the own axis"),
    "alpha_y": Parameter("risk", "alpha_y", "m2", 1e-3, 1e9, "printed risk ellipse across the own axis"),
    "give_way_gain": _role("give_way", "", "factor of K_ca towards a ship to which one gives way"),
    "stand_on_gain": _role("stand_on", "", "factor of K_ca towards a ship on which one relies"),
    "free_gain": _role("none", "", "factor of K_ca towards other ships"),
    "steadiness": _role("steadiness", "", "factor of mu_1 and mu_2 of a ship that stands on"),
    "act_within": _role("act_within", "m", "gap of the own line within which a ship acts"),
    "resume_beyond": _role("resume_beyond", "m", "gap of the own line beyond which it returns"),
    "clear_by": _role("clear_by", "m", "gap by which a plan clears"),
    "visible_offset": _role("visible_offset", "m", "least offset of a ship that gives way to one side"),
    "visible_factor": _role("visible_factor", "", "greatest speed factor of a ship that begins to slow down"),
    "reserve": _role("reserve", "", "periods that a ship that stands on keeps in hand"),
    "patience": _role("patience", "", "periods lost after which a ship takes the first gap"),
    "T_1": Parameter("kinematics", "time_constant", "s", 1e-3, 1e6, "time constant of the course"),
    "chi_max": Parameter("kinematics", "course_limit", "rad", 1e-3, math.pi / 2, "greatest steering angle"),
    "K_e": Parameter("kinematics", "steering_gain", "1/m", 1e-9, 1e3, "gain of the line-of-sight steering"),
    "beta": Parameter("", "beta", "", 1e-12, 1e6, "penalty of NADMM [1/m^2]"),
    "lambda": Parameter("", "relaxation", "", 1e-9, 2.0 - 1e-9, "relaxation of NADMM"),
}


def with_parameter(settings: Settings, name: str, value: float) -> Settings:
    """Set one of `PARAMETERS`, in SI units; those of roles change nothing where settings know no roles.

    >>> with_parameter(HEAD_ON, "K_y", 0.5).weights.K_y
    0.5
    """
    parameter = PARAMETERS[name]
    if not parameter.low <= value <= parameter.high:
        raise ValueError(f"{name} must lie in [{parameter.low:g}, {parameter.high:g}], got {value:g}")
    if not parameter.group:
        return replace(settings, **{parameter.name: value})  # type: ignore[arg-type]
    found = getattr(settings, parameter.group)
    if found is None:
        return settings
    changed = replace(settings, **{parameter.group: replace(found, **{parameter.name: value})})
    if parameter.group != "weights" or changed.roles is None:
        return changed
    crossing = replace(changed.roles.crossing, **{parameter.name: value})
    return replace(changed, roles=replace(changed.roles, crossing=crossing))
