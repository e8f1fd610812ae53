"""How a solve ended: a value whose text a person can read."""

from __future__ import annotations

from enum import Enum


class Outcome(Enum):
    """End of one solve; the value is the sentence that goes into logs."""

    CONVERGED = "converged"
    ITERATION_LIMIT = "the solver reached its iteration or time limit; raise it, or check the bounds"
    INFEASIBLE = "the solver found no feasible trajectory; check the bounds on the offset"
    NOT_FINITE = "the solver returned a value that is not finite; check the broadcast trajectories"
    FAILED = "the solver stopped with an error of its own"

    @property
    def usable(self) -> bool:
        """Whether the trajectory may be sailed."""
        return self is Outcome.CONVERGED
