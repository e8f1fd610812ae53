"""The dynamic-bumper MPC for congested inland waters, as a controller of a ship: `control: bumper`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from ccas_core.controllers import AbstractController
from ccas_core.hookspecs import PluginInfo, hookimpl

from .controller import BumperController

CONTROLLER: Final = BumperController()


@hookimpl
def ccas_plugin_info() -> PluginInfo:
    """Say what it is."""
    return PluginInfo(name="dynamic bumper MPC", version="1.0.0", api=1)


@hookimpl
def ccas_controllers() -> Iterable[AbstractController]:
    """Offer the controller."""
    yield CONTROLLER
