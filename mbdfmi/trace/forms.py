"""The languages that equations are written in, and whole texts in them."""

import keyword
import re
from collections.abc import Sequence

from . import c99, searches
from .c99 import C99
from .graph import Untraceable
from .program.functions import Program
from .write import Body, Language, Places

_WORDS = {
    *("x", "u", "p", "y", "x_rate", "np", "sp", "ca", "rates", "outputs", "functions"),
    *("double", "int", "const", "static", "void", "return", "if", "else", "long", "short", "float", "char"),
    *("auto", "break", "case", "continue", "default", "do", "enum", "extern", "for", "goto", "register"),
    *(
        "restrict",
        "signed",
        "sizeof",
        "struct",
        "switch",
        "typedef",
        "union",
        "unsigned",
        "volatile",
        "while",
    ),
    *("sin", "cos", "sqrt", "exp", "log", "floor", "fabs", "atan2", "asin", "tanh", "copysign", "inline"),
    *("minimum", "maximum", "left_knot", "eccentric_anomaly", "knot_x", "knot_c", "knot_area", "patch_c"),
    *("gamma", "j0", "j1", "jn", "y0", "y1", "yn", "signgam", "main"),
    *("rates_by_states", "rates_by_inputs", "outputs_by_states", "outputs_by_inputs"),
}
"""What no variable is called in a text."""


def identifiers(names: Sequence[str], taken: set[str]) -> list[str]:
    """Names of variables as identifiers of Python and C, all different and none taken; they are taken
    then.
    """
    found = []

    for name in names:
        text = re.sub(r"\bstate_", "", name)
        text = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_")
        text = text if re.match("[A-Za-z]", text) else f"x_{text}"
        one, k = text, 2

        while one in taken or keyword.iskeyword(one) or re.fullmatch(r"t\d*", one):
            one, k = f"{text}_{k}", k + 1

        taken.add(one)
        found.append(one)

    return found


class _Text:
    """What the texts of all languages have in common: names, bodies."""

    def __init__(self, of, form, language: Language):
        scene, taken = of.scene, set(_WORDS)
        self.of = of
        self.form = form
        self.language = language
        self.x, self.u, self.p = (
            identifiers(names, taken) for names in (of.states, of.inputs, of.parameters)
        )
        self.names = {scene.time: "t"}

        for nodes, names in ((scene.states, self.x), (scene.inputs, self.u), (scene.parameters, self.p)):
            self.names |= dict(zip(nodes, names))

        self._of_leaf = {scene.graph.nodes[k].about: name for k, name in self.names.items()}

    def _read(self, about):
        if about not in self._of_leaf:
            raise Untraceable(f"{about[0]}[{about[1]}] is read: neither state, input nor parameter")

        return self._of_leaf[about]

    def _looked_up(self, graph, node, operands):
        """A number of a table, or where in a table one is searched."""
        if self.form not in ("c", "numpy"):
            raise Untraceable(f"the scene has tables, which --{self.form} cannot say; --numpy and --c can")

        if node.op == "interval":
            _, knots, at = node.about
            return f"left_knot(knot_x, {at}, {knots}, {operands[0]})"

        name = next(name for name, (first, _) in self.of.tables.items() if first == node.about[1])
        return f"{name}[{operands[0]}]"

    def body(self, function):
        """(what its statements are, texts of its rows, names of what goes into it)."""
        wanted = [k for row in function.rows for k in row if k is not None]
        graph = self.of.scene.graph
        body = Body(graph, wanted, self.language, Places(self._read, self._looked_up, True))
        rows = [["0.0" if k is None else body[k] for k in row] for row in function.rows]
        needed = set(graph.needed(wanted))
        return body, rows, {name for k, name in self.names.items() if k in needed}

    def head(self):
        """Words at the beginning."""
        of = self.of
        has_outputs = any(function.name == "outputs" for function in of.functions)
        lines = [
            f"{of.name}: x' = rates(t, x, u, p)" + (", y = outputs(t, x, u, p)." if has_outputs else "."),
            "",
            f"Written by mbdfmi equations --{self.form}, from the kernels that simulate the scene.",
            "SI units, angles in rad; orientations are Euler parameters, scalar part last.",
        ]

        if of.moving or of.lasting:
            lines += ["", "They hold where, as at the start,"]
            lines += [f"  {text}" for text in (*of.moving, *of.lasting)]

        return "\n".join(lines)

    def unpacked(self, used, statement):
        """Statements that give names to what is used of x, u, p."""
        given = {"x": self.x, "u": self.u, "p": self.p}
        return [
            statement.format(name=name, value=f"{source}[{k}]")
            for source, names in given.items()
            for k, name in enumerate(names)
            if name in used
        ]

    def constants(self):
        """Names and values at the start: (name, value) of what a module begins with."""
        of = self.of
        names = {"STATES": of.states, "INPUTS": of.inputs, "PARAMETERS": of.parameters}

        if any(function.name == "outputs" for function in of.functions):
            names["OUTPUTS"] = of.outputs

        return {name: tuple(values) for name, values in names.items()}, {"X": of.x, "U": of.u, "P": of.p}


# Python


def _python_number(value):
    text = repr(value)
    return f"np.{text}" if text in ("inf", "nan") else "-np.inf" if text == "-inf" else text


_NUMPY = Language(
    calls={
        "abs": "np.abs",
        "min": "np.minimum",
        "max": "np.maximum",
        "atan2": "np.arctan2",
        "asin": "np.arcsin",
        "asinh": "np.arcsinh",
        "pow": "np.power",
    }
    | {
        name: f"np.{name}"
        for name in ("sqrt", "sin", "cos", "exp", "log", "tanh", "floor", "copysign", "isfinite")
    }
    | {"real": "np.float64", "whole": "_whole", "not": "np.logical_not"},
    number=_python_number,
    select="np.where({0}, {1}, {2})",
    statement="{name} = {value}",
    kinds={},
)

_ARRAY = '''def _array(*rows):
    """The rows as an array; numbers take the shape of the arrays among them."""
    return np.array(np.broadcast_arrays(*(np.asarray(row) for row in rows))) if rows else np.zeros(0)'''

_LEFT_KNOT = '''def left_knot(knot_x, first, knots, x):
    """Where the knot left of x stands, of `knots` from `first` on."""
    found = np.searchsorted(knot_x[first : first + knots], x, side="right") - 1
    return first + np.clip(found, 0, knots - 2)'''

_ECCENTRIC_ANOMALY = '''def eccentric_anomaly(M, e):
    """E (rad) of Kepler's equation E - e sin E = M."""
    E = M + e * np.sin(M)

    for _ in range(50):
        E = E - (E - e * np.sin(E) - M) / (1.0 - e * np.cos(E))

    return E'''

_WHOLE = '''def _whole(x):
    """x made a whole number, towards zero."""
    return np.trunc(x).astype(int)'''

_NUMPY_HELPERS = {"_whole": _WHOLE, "interval": _LEFT_KNOT, "eccentric_anomaly": _ECCENTRIC_ANOMALY}


def numpy_text(of) -> str:
    """A module of functions that take numbers, or arrays of them along further axes."""
    text = _Text(of, "numpy", _NUMPY)
    parts, calls = [], set()

    for function in of.functions:
        body, rows, used = text.body(function)
        calls |= body.calls
        lines = text.unpacked(used, "{name} = {value}") + body.lines
        listed = [row[0] if len(row) == 1 else f"[{', '.join(row)}]" for row in rows]
        lines += ["return _array(", *(f"    {row}," for row in listed), ")"]
        inside = "\n".join(f"    {line}" for line in lines)
        parts.append(f'def {function.name}(t, x, u=U, p=P):\n    """{function.what}."""\n{inside}')

    names, values = text.constants()
    start = [f"{name} = {value!r}" for name, value in names.items()]
    start += [f"{name} = np.array({value!r})" for name, value in values.items()]
    start += [f"{name} = np.array({value!r})" for name, (_, value) in of.tables.items()]
    helpers = [_ARRAY, *(_NUMPY_HELPERS[name] for name in _NUMPY_HELPERS if name in calls)]
    head = f'"""{text.head()}\n"""\n\nimport numpy as np\n\n' + "\n".join(start)
    return "\n\n\n".join([head, *helpers, *parts]) + "\n"


# expressions

_SYMPY = Language(
    calls={"abs": "sp.Abs", "min": "sp.Min", "max": "sp.Max", "copysign": "", "real": "", "whole": ""}
    | {"eccentric_anomaly": "", "isfinite": "", "not": "sp.Not"}
    | {name: f"sp.{name}" for name in ("sqrt", "sin", "cos", "atan2", "asin", "exp", "log", "tanh", "floor")}
    | {"asinh": "sp.asinh", "pow": "sp.Pow"},
    number=lambda value: f"sp.Float({value!r}, 17)" if isinstance(value, float) else repr(value),
    select="sp.Piecewise(({1}, {0}), ({2}, True))",
    statement="{name} = {value}",
    kinds={},
)

_CASADI = Language(
    calls={
        "abs": "ca.fabs",
        "min": "ca.fmin",
        "max": "ca.fmax",
        "copysign": "ca.copysign",
        "real": "",
        "whole": "",
    }
    | {"eccentric_anomaly": "", "isfinite": "", "not": "ca.logic_not"}
    | {name: f"ca.{name}" for name in ("sqrt", "sin", "cos", "atan2", "asin", "exp", "log", "tanh", "floor")}
    | {"asinh": "ca.asinh", "pow": "ca.power"},
    number=_python_number,
    select="ca.if_else({0}, {1}, {2})",
    statement="{name} = {value}",
    kinds={},
)


def _module(text, package, lines):
    """A module in Python that builds expressions."""
    names, values = text.constants()
    start = [f"{name} = {value!r}" for name, value in {**names, **values}.items()]
    return "\n".join([f'"""{text.head()}\n"""\n\n{package}\n', *start, "", *lines]) + "\n"


def sympy_text(of) -> str:
    """A module of symbols and expressions."""
    text = _Text(of, "sympy", _SYMPY)
    lines = ['t = sp.Symbol("t", real=True)']

    for name, names in (("x", text.x), ("u", text.u), ("p", text.p)):
        lines += [f'{one} = sp.Symbol("{one}", real=True)' for one in names]
        lines.append(f"{name} = sp.Matrix([{', '.join(names)}])")

    for function in of.functions:
        body, rows, _ = text.body(function)
        listed = [f"    [{', '.join(row)}]," for row in rows]
        lines += ["", *body.lines, f"{function.name} = sp.Matrix([  # {function.what}", *listed, "])"]

    return _module(text, "import sympy as sp", lines)


def casadi_text(of) -> str:
    """A module of functions of casadi, of t, x, u, p."""
    text = _Text(of, "casadi", _CASADI)
    sizes = {"x": len(text.x), "u": len(text.u), "p": len(text.p)}
    lines = ['t = ca.SX.sym("t")', *(f'{name} = ca.SX.sym("{name}", {n})' for name, n in sizes.items())]
    lines += text.unpacked({*text.x, *text.u, *text.p}, "{name} = {value}")

    for function in of.functions:
        body, rows, _ = text.body(function)
        listed = [f"    ca.horzcat({', '.join(row)})," for row in rows]
        lines += ["", *body.lines, f"_{function.name} = ca.vertcat(  # {function.what}", *listed, ")"]
        lines.append(
            f'{function.name} = ca.Function("{function.name}", [t, x, u, p], [_{function.name}], '
            f'["t", "x", "u", "p"], ["{function.name}"])'
        )

    return _module(text, "import casadi as ca", lines)


# C


def c_text(of) -> str:
    """A file of functions in C99."""
    text = _Text(of, "c", C99)
    parts, calls = [], set()

    for function in of.functions:
        body, rows, used = text.body(function)
        calls |= body.calls
        width = len(rows[0]) if rows else 1
        result = {"rates": "x_rate", "outputs": "y"}.get(function.name, "J")
        lines = [f"(void){name};" for name in _unused(text, used)]
        lines += text.unpacked(used, "const double {name} = {value};") + body.lines
        values = [value for row in rows for value in row]
        lines += [f"{result}[{k}] = {value};" for k, value in enumerate(values)]
        inside = "\n".join(f"    {line}" for line in lines)
        shape = f", {len(rows)} x {width}, by rows" if function.name not in ("rates", "outputs") else ""
        head = f"{_C_HEAD.format(name=function.name, result=result)}"
        parts.append(f"/* {function.what}{shape} */\n{head};\n{head}\n{{\n{inside}\n}}")

    listed = [
        f"/* {name}:\n{_listed(names, values)} */"
        for name, names, values in (
            ("x", of.states, of.x),
            ("u", of.inputs, of.u),
            ("p", of.parameters, of.p),
        )
        if names
    ]

    if any(function.name == "outputs" for function in of.functions):
        listed.append(f"/* y:\n{_listed(of.outputs, None)} */")

    tables = [
        f"static const double {name}[] = {{{', '.join(map(c99.number, values))}}};"
        for name, (_, values) in of.tables.items()
    ]
    program = Program()
    helpers = program.text(searches.called(program, calls), "\n".join(parts))
    start = ["#include <math.h>\n#include <stdint.h>", *listed, *helpers, *tables, *parts]
    return f"/* {text.head()} */\n\n" + "\n\n".join(text for text in start if text) + "\n"


def _unused(text, used):
    """Arguments that a function does not look at."""
    given = {"t": ["t"], "x": text.x, "u": text.u, "p": text.p}
    return [name for name, names in given.items() if used.isdisjoint(names)]


def _listed(names, values):
    """Names and values at the start, a line each."""
    return "\n".join(
        f"     [{k}] {name}" + (f" = {values[k]!r}" if values else "") for k, name in enumerate(names)
    )


_C_HEAD = "void {name}(double t, const double *x, const double *u, const double *p, double *{result})"

FORMS = {"c": c_text, "numpy": numpy_text, "sympy": sympy_text, "casadi": casadi_text}
"""What equations can be written in."""
