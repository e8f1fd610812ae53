"""One formula, two meanings: numbers in, numbers out; CasADi symbols in, symbols out."""

from __future__ import annotations

from typing import TypeVar

import casadi as ca

Scalar = TypeVar("Scalar", float, ca.SX, ca.MX)
