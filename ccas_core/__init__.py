"""Collision avoidance for inland ships: exchangeable traffic rules above one distributed MPC.

The names in `__all__` are public; everything else may change.  Each is loaded when it is first used, so
that `import ccas_core` is light.

>>> from ccas_core import NedPose
>>> NedPose.__module__
'ccas_core.frames'
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from .dmpc.parameters import Settings as Settings
    from .dmpc.solvers import AbstractLocalSolver as AbstractLocalSolver
    from .dmpc.solvers import make_solver as make_solver
    from .errors import CcasError as CcasError
    from .errors import Diagnostic as Diagnostic
    from .errors import InputError as InputError
    from .errors import PluginError as PluginError
    from .errors import RulesetError as RulesetError
    from .errors import ScenarioError as ScenarioError
    from .frames import NedPose as NedPose
    from .hookspecs import hookimpl as hookimpl
    from .plugins import Plugins as Plugins
    from .plugins import load
    from .priority import PriorityGraph as PriorityGraph
    from .roles import Geometry as Geometry
    from .roles import PassingSide as PassingSide
    from .ships import UNKNOWN as UNKNOWN
    from .ships import Hull as Hull
    from .ships import Ship as Ship
    from .ships import ShipId as ShipId
    from .sim.frame import Frame as Frame
    from .sim.metrics import summary as summary
    from .sim.run_folder import RunWriter as RunWriter
    from .sim.run_reading import read_run as read_run
    from .sim.scenario import Scenario as Scenario
    from .sim.scenario_dump import dump_scenario as dump_scenario
    from .sim.scenario_file import load_scenario as load_scenario
    from .sim.voyage import voyage as voyage
    from .tapd.facts import PairFacts as PairFacts
    from .tapd.ruleset import AbstractRuleset as AbstractRuleset
    from .tapd.ruleset import PairRuleset as PairRuleset
    from .tapd.ruleset import Situation as Situation
    from .verdict import Citation as Citation
    from .verdict import Confidence as Confidence
    from .verdict import Kind as Kind
    from .verdict import Verdict as Verdict
    from .waterway import Leg as Leg
    from .waterway import Obstacle as Obstacle
    from .waterway import Region as Region
    from .waterway import Towards as Towards
    from .waterway import Waters as Waters
    from .waterway import Waterway as Waterway
    from .world import ShipReport as ShipReport
    from .world import World as World

    load_plugins = load

_HOMES: Final = {  # module, and the name there if it is another
    "AbstractLocalSolver": "dmpc.solvers",
    "AbstractRuleset": "tapd.ruleset",
    "CcasError": "errors",
    "Citation": "verdict",
    "Confidence": "verdict",
    "Diagnostic": "errors",
    "Frame": "sim.frame",
    "Geometry": "roles",
    "Hull": "ships",
    "InputError": "errors",
    "Kind": "verdict",
    "Leg": "waterway",
    "NedPose": "frames",
    "Obstacle": "waterway",
    "PairFacts": "tapd.facts",
    "PairRuleset": "tapd.ruleset",
    "PassingSide": "roles",
    "PluginError": "errors",
    "Plugins": "plugins",
    "PriorityGraph": "priority",
    "Region": "waterway",
    "RulesetError": "errors",
    "RunWriter": "sim.run_folder",
    "Scenario": "sim.scenario",
    "ScenarioError": "errors",
    "Settings": "dmpc.parameters",
    "Ship": "ships",
    "ShipId": "ships",
    "ShipReport": "world",
    "Situation": "tapd.ruleset",
    "Towards": "waterway",
    "UNKNOWN": "ships",
    "Verdict": "verdict",
    "Waters": "waterway",
    "Waterway": "waterway",
    "World": "world",
    "dump_scenario": "sim.scenario_dump",
    "hookimpl": "hookspecs",
    "load_plugins": "plugins:load",
    "load_scenario": "sim.scenario_file",
    "make_solver": "dmpc.solvers",
    "read_run": "sim.run_reading",
    "summary": "sim.metrics",
    "voyage": "sim.voyage",
}
__all__ = list(_HOMES)

if not TYPE_CHECKING:  # a type checker reads the imports above, and knows what is not there

    def __getattr__(name: str) -> object:
        """Load a public name when it is first used."""
        if name not in _HOMES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        home, _, there = _HOMES[name].partition(":")
        found = globals()[name] = getattr(import_module(f".{home}", __name__), there or name)
        return found

    def __dir__() -> list[str]:
        """List public names, loaded or not."""
        return sorted({*globals(), *__all__})
