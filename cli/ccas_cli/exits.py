"""How a command ends: exit codes, and the one place where an error becomes a message and a code."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Callable
from enum import IntEnum
from functools import wraps
from typing import Final, ParamSpec

import typer

from ccas_core.errors import CcasError

DEBUG: Final = "CCAS_DEBUG"  # environment variable that asks for tracebacks

_P = ParamSpec("_P")


class Code(IntEnum):
    """Exit codes of `ccas` (contract), and those of the shell for a program that was stopped."""

    CLEAN = 0
    FINDINGS = 1  # a collision, a rule fault, a failed test
    WRONG_USE = 2  # wrong use, or input that cannot be read
    UNDECIDED = 3
    FAULT = 101  # a fault of ours
    INTERRUPTED = 130  # Ctrl-C
    PIPE_CLOSED = 141  # whoever read our output has gone


def answered(command: Callable[_P, None]) -> Callable[_P, None]:
    """Let a command end as the contract says, whatever it raises."""

    @wraps(command)
    def run(*args: _P.args, **kwargs: _P.kwargs) -> None:
        try:
            command(*args, **kwargs)
            sys.stdout.flush()
        except (typer.Exit, typer.Abort, typer.BadParameter):
            raise
        except CcasError as error:
            print(error, file=sys.stderr)
            raise typer.Exit(Code.WRONG_USE) from None
        except KeyboardInterrupt:
            print("interrupted", file=sys.stderr)
            raise typer.Exit(Code.INTERRUPTED) from None
        except BrokenPipeError:
            _forget_output()
            raise typer.Exit(Code.PIPE_CLOSED) from None
        except Exception as error:  # noqa: BLE001 - whatever else comes out is a fault of ours
            _confess(error)
            raise typer.Exit(Code.FAULT) from None

    return run


def _confess(error: Exception) -> None:
    if os.environ.get(DEBUG):
        traceback.print_exception(error, file=sys.stderr)
    first_line = next(iter(str(error).splitlines()), "")
    hint = "" if os.environ.get(DEBUG) else f"; {DEBUG}=1 shows where, please report that"
    print(f"ccas: a fault of ours: {type(error).__name__}: {first_line}{hint}", file=sys.stderr)


def _forget_output() -> None:
    """Let what is still in the buffer go nowhere, for the interpreter flushes it once more at its end."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
