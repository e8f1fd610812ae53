"""CasADi functions as Python source that `compiling` compiles: one statement per instruction.

A formula that is stated once in CasADi can then be called from compiled loops.  What is written
here knows the operations of CasADi and nothing of the model.
"""

from __future__ import annotations

import math
from typing import Final

import casadi as ca

_UNARY: Final = {
    ca.OP_ASSIGN: "{0}",
    ca.OP_NEG: "-{0}",
    ca.OP_EXP: "math.exp({0})",
    ca.OP_LOG: "math.log({0})",
    ca.OP_SQRT: "math.sqrt({0})",
    ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "2.0 * {0}",
    ca.OP_INV: "1.0 / {0}",
    ca.OP_SIN: "math.sin({0})",
    ca.OP_COS: "math.cos({0})",
    ca.OP_TAN: "math.tan({0})",
    ca.OP_ASIN: "math.asin({0})",
    ca.OP_ACOS: "math.acos({0})",
    ca.OP_ATAN: "math.atan({0})",
    ca.OP_SINH: "math.sinh({0})",
    ca.OP_COSH: "math.cosh({0})",
    ca.OP_TANH: "math.tanh({0})",
    ca.OP_ASINH: "math.asinh({0})",
    ca.OP_ACOSH: "math.acosh({0})",
    ca.OP_ATANH: "math.atanh({0})",
    ca.OP_EXPM1: "math.expm1({0})",
    ca.OP_LOG1P: "math.log1p({0})",
    ca.OP_ERF: "math.erf({0})",
    ca.OP_FLOOR: "np.floor({0})",
    ca.OP_CEIL: "np.ceil({0})",
    ca.OP_FABS: "abs({0})",
    ca.OP_SIGN: "np.sign({0})",
    ca.OP_NOT: "1.0 if {0} == 0.0 else 0.0",
}
_BINARY: Final = {
    ca.OP_ADD: "{0} + {1}",
    ca.OP_SUB: "{0} - {1}",
    ca.OP_MUL: "{0} * {1}",
    ca.OP_DIV: "{0} / {1}",
    ca.OP_POW: "{0} ** {1}",
    ca.OP_CONSTPOW: "{0} ** {1}",
    ca.OP_FMOD: "math.fmod({0}, {1})",
    ca.OP_COPYSIGN: "math.copysign({0}, {1})",
    ca.OP_ATAN2: "math.atan2({0}, {1})",
    ca.OP_HYPOT: "math.hypot({0}, {1})",
    ca.OP_FMIN: "np.fmin({0}, {1})",
    ca.OP_FMAX: "np.fmax({0}, {1})",
    ca.OP_LT: "1.0 if {0} < {1} else 0.0",
    ca.OP_LE: "1.0 if {0} <= {1} else 0.0",
    ca.OP_EQ: "1.0 if {0} == {1} else 0.0",
    ca.OP_NE: "1.0 if {0} != {1} else 0.0",
    ca.OP_AND: "1.0 if {0} != 0.0 and {1} != 0.0 else 0.0",
    ca.OP_OR: "1.0 if {0} != 0.0 or {1} != 0.0 else 0.0",
    ca.OP_IF_ELSE_ZERO: "{1} if {0} != 0.0 else 0.0",
}


def python_source(function: ca.Function) -> str:
    """Write an SX function as the source of a Python function of the same name.

    It takes one array for each input, then one for each output, and returns nothing: a vector is
    indexed [i], a matrix [i, j].  All inputs are read before the first output is written, so an
    array may be both; every element of an output is written, zeros of its structure included.

    Examples
    --------
    >>> x = ca.SX.sym("x", 2)
    >>> print(python_source(ca.Function("area", [x], [2.5 * x[0] * ca.sin(x[1])])))
    def area(a0, r0):
        a0_0 = a0[0]
        a0_1 = a0[1]
        w0 = 2.5
        w1 = a0_0
        w0 = w0 * w1
        w1 = a0_1
        w1 = math.sin(w1)
        w0 = w0 * w1
        r0_0 = w0
        r0[0] = r0_0
    <BLANKLINE>
    """
    if not function.is_a("SXFunction"):
        raise NotImplementedError(f"{function.name()} is not made of SX")
    arguments = [f"a{i}" for i in range(function.n_in())] + [f"r{i}" for i in range(function.n_out())]
    inputs = [_elements(function.sparsity_in(i)) for i in range(function.n_in())]
    outputs = [_elements(function.sparsity_out(i)) for i in range(function.n_out())]
    reads, work, writes = [], [], []
    for n in range(function.n_instructions()):
        operation = function.instruction_id(n)
        taken, given = function.instruction_input(n), function.instruction_output(n)
        if operation == ca.OP_INPUT:
            array, element = taken
            reads.append(f"a{array}_{element} = a{array}[{inputs[array][element]}]")
            work.append(f"w{given[0]} = a{array}_{element}")
        elif operation == ca.OP_OUTPUT:
            array, element = given
            work.append(f"r{array}_{element} = w{taken[0]}")
            writes.append(f"r{array}[{outputs[array][element]}] = r{array}_{element}")
        else:
            work.append(f"w{given[0]} = {_expression(function, n)}")
    for i in range(function.n_out()):
        full = _elements(ca.Sparsity.dense(*function.size_out(i)))
        writes += [f"r{i}[{place}] = 0.0" for place in full if place not in set(outputs[i])]
    body = [*dict.fromkeys(reads), *work, *writes]
    lines = [f"def {function.name()}({', '.join(arguments)}):", *(f"    {line}" for line in body)]
    return "\n".join(lines) + "\n"


def _elements(sparsity: ca.Sparsity) -> list[str]:
    """Index of each stored element, as text: "i" in a vector, "i, j" in a matrix."""
    rows, columns = sparsity.get_triplet()
    if sparsity.size2() == 1:
        return [f"{row}" for row in rows]
    return [f"{row}, {column}" for row, column in zip(rows, columns, strict=True)]


def _expression(function: ca.Function, n: int) -> str:
    operation = function.instruction_id(n)
    if operation == ca.OP_CONST:
        constant = function.instruction_constant(n)
        return repr(float(constant)) if math.isfinite(constant) else f"np.float64({str(constant)!r})"
    form = _UNARY.get(operation) or _BINARY.get(operation)
    if form is None:
        raise NotImplementedError(f"{function.name()}: operation {operation} of CasADi has no translation")
    return form.format(*(f"w{slot}" for slot in function.instruction_input(n)))
