"""Loops over numbers, compiled by numba where it is installed: this module alone imports it.

What is compiled is the text of Python functions that use numbers, arrays, `math` and `np` only; without numba
they run as they are written, with the same results.
"""

from __future__ import annotations

import atexit
import hashlib
import importlib.util
import inspect
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple


def fast(*routines: Callable[..., Any], **numbers: float) -> tuple[Callable[..., Any], ...]:
    """Compile routines that see one another and `numbers`; without numba they come back as they are.

    Only the first call on a machine compiles, which takes about a second.
    """
    if find_spec("numba") is None:
        return routines
    module = compiled_module(map(inspect.getsource, routines), numbers)
    return tuple(getattr(module, routine.__name__) for routine in routines)


def compiled_module(
    functions: Iterable[str], numbers: Mapping[str, float], tuples: Iterable[type[NamedTuple]] = ()
) -> ModuleType:
    """Compile functions, given by their source, that call one another by name.

    The text goes into a module in the user's cache folder, named by its content and by the version of
    numba; numba keeps its machine code beside it, so that only the first start on a machine compiles.

    Parameters
    ----------
    functions
        Sources; a function sees the others, `numbers`, `math` and `np`, and nothing else of the module in
        which it was written.
    numbers
        Constants that they name.
    tuples
        Classes of named tuples that they make or take; they are those of the module, then.

    Raises
    ------
    ImportError
        If numba is not installed.
    """
    import numba  # type: ignore[import-untyped, unused-ignore]  # heavy

    decorator = '@numba.njit(cache=True, nogil=True, error_model="numpy", no_cfunc_wrapper=True)\n'
    text = _HEADER + "".join(f"{name} = {number!r}\n" for name, number in numbers.items()) + "\n\n"
    text += "\n\n".join([*map(inspect.getsource, tuples), *(decorator + part for part in functions)])
    versions = f"{numba.__version__} {sys.version_info[:2]}\n"
    name = "generated_" + hashlib.sha256((versions + text).encode()).hexdigest()[:20]
    return _imported(name, text)


def is_compiled(module: ModuleType, name: str) -> bool:
    """Whether machine code of a routine of a `compiled_module` waits in the cache."""
    function = getattr(module, name)
    pattern = f"{module.__name__}.{name}-{function.py_func.__code__.co_firstlineno}.*.nbi"
    return any(Path(function.stats.cache_path).glob(pattern))


_HEADER = '''"""Written by ccas_core.compiling; may be deleted."""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np


'''


def _imported(name: str, text: str) -> ModuleType:
    if name not in sys.modules:
        path = cache_folder() / f"{name}.py"
        # A file that is there stays untouched: numba judges its machine code by the file's time.
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            _write(path, text)
        spec = importlib.util.spec_from_file_location(name, path)
        if spec is None or spec.loader is None:
            raise ImportError(f"{path} cannot be imported")
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module  # numba looks its functions up there
        spec.loader.exec_module(module)
    return sys.modules[name]


def _write(path: Path, text: str) -> None:
    """Write in one go, so that another process never reads half a file."""
    with tempfile.NamedTemporaryFile("w", dir=path.parent, encoding="utf-8", delete=False) as file:
        file.write(text)
    Path(file.name).replace(path)


@cache
def cache_folder() -> Path:
    """Folder for generated code: the user's own, or one for this process if that is not writable."""
    home = os.environ.get("XDG_CACHE_HOME", "")
    try:
        folder = (Path(home) if home else Path.home() / ".cache") / "ccas"
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except (OSError, RuntimeError):  # not writable; or no home at all
        own = tempfile.mkdtemp(prefix="ccas-")
        atexit.register(shutil.rmtree, own, ignore_errors=True)
        return Path(own)
