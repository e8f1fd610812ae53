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
    from .hookspecs import PluginInfo as PluginInfo
    from .hookspecs import hookimpl as hookimpl
    from .plugins import Plugins as Plugins
    from .plugins import load
    from .priority import PriorityGraph as PriorityGraph
    from .regions import Hysteresis as Hysteresis
    from .regions import Law as Law
    from .regions import Region as Region
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
    from .tapd.case_file import CaseFile as CaseFile
    from .tapd.case_file import load_cases as load_cases
    from .tapd.cases import Case as Case
    from .tapd.facts import PairFacts as PairFacts
    from .tapd.library import RulesetLibrary as RulesetLibrary
    from .tapd.python_rules import PairView as PairView
    from .tapd.python_rules import PythonRule as PythonRule
    from .tapd.python_rules import RoleDecision as RoleDecision
    from .tapd.ranking import RankingCriterion as RankingCriterion
    from .tapd.ruleset import AbstractRuleset as AbstractRuleset
    from .tapd.ruleset import PairRuleset as PairRuleset
    from .tapd.ruleset import Situation as Situation
    from .tapd.ruleset_file import load_ruleset as load_ruleset
    from .tapd.ruleset_file import parse_ruleset as parse_ruleset
    from .tapd.vocabulary import VOCABULARY as VOCABULARY
    from .tapd.vocabulary import Fact as Fact
    from .tapd.vocabulary import Kind as FactKind  # noqa: F401 - public by this name
    from .tapd.vocabulary import Scope as FactScope  # noqa: F401 - public by this name
    from .tapd.vocabulary import Source as FactSource  # noqa: F401 - public by this name
    from .tapd.vocabulary import Vocabulary as Vocabulary
    from .tapd.written import WrittenRuleset as WrittenRuleset
    from .verdict import Citation as Citation
    from .verdict import Confidence as Confidence
    from .verdict import Kind as Kind
    from .verdict import Verdict as Verdict
    from .waterway import Leg as Leg
    from .waterway import Obstacle as Obstacle
    from .waterway import Towards as Towards
    from .waterway import Waters as Waters
    from .waterway import Waterway as Waterway
    from .world import ShipReport as ShipReport
    from .world import World as World

    load_plugins = load

_HOMES: Final = {  # module, and the name there if it is another
    "AbstractLocalSolver": "dmpc.solvers",
    "AbstractRuleset": "tapd.ruleset",
    "Case": "tapd.cases",
    "CaseFile": "tapd.case_file",
    "CcasError": "errors",
    "Citation": "verdict",
    "Confidence": "verdict",
    "Diagnostic": "errors",
    "Fact": "tapd.vocabulary",
    "FactKind": "tapd.vocabulary:Kind",
    "FactScope": "tapd.vocabulary:Scope",
    "FactSource": "tapd.vocabulary:Source",
    "Frame": "sim.frame",
    "Geometry": "roles",
    "Hull": "ships",
    "Hysteresis": "regions",
    "InputError": "errors",
    "Kind": "verdict",
    "Law": "regions",
    "Leg": "waterway",
    "NedPose": "frames",
    "Obstacle": "waterway",
    "PairFacts": "tapd.facts",
    "PairRuleset": "tapd.ruleset",
    "PairView": "tapd.python_rules",
    "PassingSide": "roles",
    "PluginError": "errors",
    "PluginInfo": "hookspecs",
    "Plugins": "plugins",
    "PriorityGraph": "priority",
    "PythonRule": "tapd.python_rules",
    "RankingCriterion": "tapd.ranking",
    "Region": "regions",
    "RoleDecision": "tapd.python_rules",
    "RulesetError": "errors",
    "RulesetLibrary": "tapd.library",
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
    "VOCABULARY": "tapd.vocabulary",
    "Verdict": "verdict",
    "Vocabulary": "tapd.vocabulary",
    "Waters": "waterway",
    "Waterway": "waterway",
    "World": "world",
    "WrittenRuleset": "tapd.written",
    "dump_scenario": "sim.scenario_dump",
    "hookimpl": "hookspecs",
    "load_cases": "tapd.case_file",
    "load_plugins": "plugins:load",
    "load_ruleset": "tapd.ruleset_file",
    "load_scenario": "sim.scenario_file",
    "make_solver": "dmpc.solvers",
    "parse_ruleset": "tapd.ruleset_file",
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
