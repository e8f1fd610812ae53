"""Scenarios written as YAML files, resolved: read back, they give the same voyage."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from ..agent.events import Conduct
from ..controllers import AbstractController
from ..dmpc.parameters import PARAMETERS
from ..frames import FloatArray
from ..quantities import ANGLE, LENGTH, MASS, NUMBER, QUANTITY_OF, SPEED, TIME
from ..regions import Hysteresis
from ..ships import Facts, Hull
from ..tapd.vocabulary import VOCABULARY, Scope, Vocabulary
from ..waterway import Waters
from ..yaml_nodes import written
from .scenario import Plan, Scenario
from .scenario_facts import write_facts
from .scenario_file import SCHEMA, full_circle
from .scenario_steering import Tree, current_tree, steering_tree

_WIDTH: Final = 100  # of a line that is written


def dump_scenario(
    scenario: Scenario,
    vocabulary: Vocabulary = VOCABULARY,
    controllers: Mapping[str, AbstractController] | None = None,
) -> str:
    """Write a scenario as resolved: read back, it gives the same voyage.

    What came from a file comes back bit for bit; other numbers keep twelve digits.  Positions
    are [east, north], whatever they were.  Facts of plugins need the vocabulary that has them, and
    options of controllers the controllers.
    """
    control = scenario.control
    chosen = {"wait": control.wait, "risk_shape": control.risk_shape}
    tree: dict[str, Tree] = {
        "schema": SCHEMA,
        "name": written(scenario.name),
        **{key: written(text) for key in ("title", "description") if (text := getattr(scenario, key))},
        "time": {"step": TIME.write(scenario.time_step), "duration": TIME.write(scenario.duration)},
        "waters": _waters_tree(scenario.waters, vocabulary),
        "ships": [_plan_tree(plan, vocabulary, controllers or {}) for plan in scenario.ships],
        "control": {
            "horizon": str(control.horizon),
            "iterations": str(control.iterations),
            "profile": control.profile,
            **{key: word for key, word in chosen.items() if word is not None},
            **({"starts": control.starts} if control.starts is not None else {}),
            "deadlock_detection": str(control.deadlock_detection).lower(),
            "parameters": {
                name: QUANTITY_OF[PARAMETERS[name].unit].write(value)
                for name, value in control.parameters.items()
            },
        },
        "bus": {
            "loss": NUMBER.write(scenario.bus.loss),
            "delay": TIME.write(scenario.bus.delay),
            "seed": str(scenario.bus.seed),
        },
    }
    return "\n".join(_lines(tree)) + "\n"


def _waters_tree(waters: Waters, vocabulary: Vocabulary) -> dict[str, Tree]:
    tree: dict[str, Tree] = {"ruleset": written(waters.ruleset)} if waters.ruleset else {}
    if waters.regions:
        tree["regions"] = [
            {
                "id": written(each.id),
                "ruleset": written(each.ruleset),
                **({"precedence": str(each.precedence)} if each.precedence else {}),
                "polygon": _points(each.polygon),
            }
            for each in waters.regions
        ]
    if waters.hysteresis != Hysteresis():
        kept = waters.hysteresis
        tree["hysteresis"] = {"width": LENGTH.write(kept.width), "time": TIME.write(kept.time)}
    tree["waterways"] = [
        {
            "id": written(each.id),
            "centreline": _points(each.centreline),
            "width": LENGTH.write(each.width),
            "upstream": each.upstream,
            **_facts_tree(each.facts, Scope.WATERWAY, vocabulary),
        }
        for each in waters.waterways
    ]
    if waters.obstacles:
        tree["obstacles"] = [
            {"id": written(each.id), "at": _position(each.x, each.y), "radius": LENGTH.write(each.radius)}
            for each in waters.obstacles
        ]
    return {**tree, **current_tree(waters.current)}


def _plan_tree(
    plan: Plan, vocabulary: Vocabulary, controllers: Mapping[str, AbstractController]
) -> dict[str, Tree]:
    hull = plan.ship.hull
    usual = Hull(length=hull.length, beam=hull.beam)
    safety = {
        key: LENGTH.write(getattr(hull, key))
        for key in ("safety_length", "safety_beam")
        if getattr(hull, key) != getattr(usual, key)
    }
    return {
        "id": written(plan.ship.id),
        "length": LENGTH.write(hull.length),
        "beam": LENGTH.write(hull.beam),
        **safety,
        "weight": MASS.write(plan.ship.mass),
        "route": [
            {"waterway": written(leg.waterway), "towards": leg.towards, "offset": LENGTH.write(leg.offset)}
            for leg in plan.route
        ],
        "start": _position(plan.start.x, plan.start.y),
        "course": ANGLE.write(full_circle(plan.start.course)),
        "speed": SPEED.write(plan.speed),
        **_facts_tree(plan.ship.facts, Scope.SHIP, vocabulary),
        **({"rulesets": [written(each) for each in plan.rulesets]} if plan.rulesets else {}),
        **({"conduct": plan.conduct} if plan.conduct is not Conduct.DUTIFUL else {}),
        **steering_tree(plan, controllers),
    }


def _facts_tree(facts: Facts, scope: Scope, vocabulary: Vocabulary) -> dict[str, Tree]:
    return {"facts": write_facts(facts, scope, vocabulary)} if facts else {}


def _points(points: FloatArray) -> list[Tree]:
    return [_position(north, east) for north, east in points]


def _position(north: float, east: float) -> list[Tree]:
    return [NUMBER.write(east), NUMBER.write(north)]


def _lines(tree: Mapping[str, Tree] | Sequence[Tree], width: int = _WIDTH) -> Iterator[str]:
    """Lines in block style; what fits on a line is in flow style."""
    pairs = tree.items() if isinstance(tree, Mapping) else (("-", each) for each in tree)
    for key, value in pairs:
        lead = "- " if key == "-" else f"{key}: "
        flow = lead + _flow(value)
        if isinstance(value, str) or len(flow) <= width:
            yield flow
        elif key == "-":
            first, *rest = _lines(value, width - 2)
            yield lead + first
            yield from ("  " + line for line in rest)
        else:
            yield lead.rstrip()
            yield from ("  " + line for line in _lines(value, width - 2))


def _flow(tree: Tree) -> str:
    if isinstance(tree, str):
        return tree
    if isinstance(tree, Mapping):
        return "{" + ", ".join(f"{key}: {_flow(value)}" for key, value in tree.items()) + "}"
    return "[" + ", ".join(_flow(each) for each in tree) + "]"
