"""All kernels that some call, in C: they are looked at again and again until nothing more becomes known of
any."""

from collections.abc import Mapping
from types import FunctionType

import numpy as np

from ...kernels.layout import ARRAY, COUNTS, SLOT, array_length
from ..graph import INT, REAL, Untraceable
from ..plain import ROOM
from . import shapes
from .expressions import UNKNOWN, Text, plain
from .helpers import HELPERS
from .layout_c import lines, without_unread, words
from .reading import reading
from .shapes import ANY_INT, Array, Number, Tuple, View, join, loose
from .statements import Statements
from .types import KINDS, WIDE, Types, constant

RUN = "run"
"""The pointer to a run's buffers, as functions take it for `m` and `d`."""

_RESERVED = {
    *(
        "auto",
        "break",
        "case",
        "char",
        "const",
        "continue",
        "default",
        "do",
        "double",
        "else",
        "enum",
        "extern",
    ),
    *(
        "float",
        "for",
        "goto",
        "if",
        "inline",
        "int",
        "long",
        "register",
        "restrict",
        "return",
        "short",
        "signed",
    ),
    *(
        "sizeof",
        "static",
        "struct",
        "switch",
        "typedef",
        "union",
        "unsigned",
        "void",
        "volatile",
        "while",
        "bool",
    ),
    *("y0", "y1", "yn", "j0", "j1", "jn", "gamma", "signgam", "main", "true", "false", RUN),
}

_IN_C = {name: f"{'m' if array.buffer in ('ints', 'reals') else 'd'}_{name}" for name, array in ARRAY.items()}
"""What arrays of the model are called in C."""

_OF_ARRAYS = frozenset(_IN_C.values())


class Function:
    """One kernel, for arguments of one kind. name : in C. variables : what is known of them, arguments
    included. returned : what it returns. acts : whether it changes anything. stores : arguments that are
    arrays and written to, or name such a one.
    """

    def __init__(self, python: FunctionType, name: str, arguments: list):
        self.python = python
        self.name = name
        self.reading = reading(python)
        self.parameters = self.reading.parameters
        self.names = self.reading.names
        self.variables: dict[str, object] = dict(zip(self.parameters, arguments, strict=True))
        self.returned: object = None
        self.acts = False
        self.stores: set[str] = set()
        self.items: list = []
        self.changed = True
        self.callers: set[Function] = set()
        self.versions: dict[str, str] = {}
        self._others: dict[str, object] = {}
        self.takes_run = any(isinstance(shape, View) for shape in arguments)

    def spelled(self, name: str) -> str:
        """A variable's name in C, where it is read."""
        return self.word(self.versions.get(name, name))

    @staticmethod
    def word(name: str) -> str:
        """A name as one that C leaves free."""
        return f"{name}_" if name in _RESERVED or name in _OF_ARRAYS or name in KINDS.values() else name

    def learn(self, name: str, shape, counts: bool = False):
        """A variable may be that too. Returns all that it may be. counts : it is a loop's counter.

        One that is a number here and a tuple there, or a real number here and counts there, is two in C;
        whoever reads it means the one given a value last.
        """
        shape = _kept(shape)
        versions = (name, *(f"{name}_{k}" for k in range(2, 10)))
        known = {each: self.variables.get(each) for each in versions}
        version = next(
            each
            for each, before in known.items()
            if _go_together(before, shape) and not (counts and _is_real(before))
        )
        self.versions[name] = version
        before = self.variables.get(version)
        found = self.variables[version] = join(before, shape)
        self.changed |= found != before
        return found

    def known(self, name: str):
        """What a variable may be where it is read, or None."""
        return self.variables.get(self.versions.get(name, name))

    def learn_returned(self, shape):
        """It may return that too. Returns all that it may."""
        before = self.returned
        self.returned = join(before, _kept(shape))
        self._tell(self.returned != before)
        return self.returned

    def acts_now(self):
        """It changes something."""
        before, self.acts = self.acts, True
        self._tell(not before)

    def writes_to(self, name: str):
        """It writes to an array that it is given."""
        before = name in self.stores
        self.stores.add(name)
        self._tell(not before)

    def _tell(self, changed):
        """What callers see has changed."""
        if changed:
            self.changed = True

            for caller in self.callers:
                caller.changed = True

    def another(self, shape, counter: bool = False) -> str:
        """A name for what the kernel has no name for."""
        name = f"{'turn' if counter else 'all'}_{len(self._others) + 1}"
        self._others[name] = None if counter else shape
        return name

    def counts_alone(self, name: str) -> bool:
        """Whether a name is a loop's counter and nothing else."""
        return name in self.reading.counters

    def write(self, program):
        """Looks at all of it once more."""
        self.changed = False
        self._others, self.versions = {}, {}

        try:
            self.items, _ = Statements(program, self).block(self.reading.body)
        except Untraceable as error:
            where = f"{self.python.__module__.removeprefix(ROOM + '.')}.{self.python.__name__}"
            raise Untraceable(f"{where}: {error}") from None

    def text(self, types: Types) -> str:
        """The function in C."""
        known = {
            self.word(name): shape for name, shape in self.variables.items() if name not in self.parameters
        }
        shaped = {name: shape for name, shape in (known | self._others).items() if shape is not None}
        counters = set(map(self.word, self.reading.counters))
        kinds = {
            name: self._declared(types, name, shape) for name, shape in shaped.items() if name not in counters
        }
        items = without_unread(self.items, {*kinds, *map(self.word, self.parameters)})
        inside = lines(items, kinds)
        used = set().union(*(words(line) for line in inside)) if inside else set()
        unused = [f"    (void){name};" for name, _ in self._given(types) if name not in used]
        return "\n".join([f"{self.head(types)}", "{", *unused, *inside, "}"])

    def head(self, types: Types) -> str:
        """Its declaration."""
        given = ", ".join(text for _, text in self._given(types)) or "void"
        returned = types.name(self.returned)
        return f"static {returned}{'' if returned.endswith('*') else ' '}{self.name}({given})"

    def _declared(self, types, word, shape):
        """A variable's declaration: arrays are for reading, but those that are written to."""
        text = types.declared(shape, word)
        return text.removeprefix("const ") if word in map(self.word, self.stores) else text

    def _given(self, types):
        """(name, declaration) of what it takes."""
        found = [(RUN, f"const Run *{RUN}")] if self.takes_run else []

        for name in self.parameters:
            shape = self.variables[name]

            if not isinstance(shape, View):
                word = self.word(name)
                found.append((word, self._declared(types, word, shape)))

        return found


def _is_real(shape):
    return isinstance(shape, Number) and shape.kind == REAL


def _go_together(a, b):
    """Whether one variable of C can be both."""
    return (
        a is None or (isinstance(a, Number) and isinstance(b, Number)) or loose(a) == loose(b) or _alike(a, b)
    )


def _alike(a, b):
    """Whether two tuples can be joined."""
    if not (isinstance(a, Tuple) and isinstance(b, Tuple)):
        return False

    same = (a.named, len(a.members)) == (b.named, len(b.members))
    return same and all(map(_go_together, a.members, b.members))


def _kept(shape):
    """What is remembered of a shape: which array it is does not matter."""
    shape = shapes.as_value(shape)
    return Array(shape.kind) if isinstance(shape, Array) else shape


class Program:
    """Kernels in C for the structure of one model.

    ints : its structure, or None where kernels take no model. replaced : kernel -> name of a function of the
    same arguments that stands for it, and is written elsewhere. behind : name of an array -> statement behind
    each that writes to it.
    """

    def __init__(
        self,
        ints: np.ndarray | None = None,
        replaced: Mapping[FunctionType, str] | None = None,
        behind: Mapping[str, str] | None = None,
    ):
        self.types = Types()
        self.behind = dict(behind or {})
        self.replaced = dict(replaced or {})
        self.functions: dict[tuple, Function] = {}
        self._names: dict[str, Function] = {}
        self._arrays: dict[str, tuple[int, list[int]]] = {}
        self._counts: dict[str, int] = {}

        if ints is not None:
            self._counts = dict(zip(COUNTS, ints.tolist()))
            self._arrays = _arrays_of(ints, self._counts)

    def add(self, python: FunctionType, arguments: list, name: str | None = None) -> Function:
        """A kernel, and all that it calls."""
        function = self._function(python, arguments, name)

        while waiting := [each for each in self.functions.values() if each.changed]:
            for each in waiting:
                each.write(self)

        return function

    def _function(self, python, arguments, name=None):
        key = (python, tuple(map(loose, arguments)))

        if key not in self.functions:
            made = Function(python, name or self._name(python), [_kept(argument) for argument in arguments])
            self.functions[key] = self._names[made.name] = made

        return self.functions[key]

    def _name(self, python):
        module = python.__module__.rpartition(".")[2]
        name = f"{module}_{python.__name__}"
        return (
            name
            if name not in self._names
            else next(f"{name}_{k}" for k in range(2, 10**6) if f"{name}_{k}" not in self._names)
        )

    # what kernels find in m and d

    def member(self, name: str) -> Text:
        """A count, or an array, of the model."""
        if name in self._counts:
            return plain(self._counts[name])

        if name == "u_buffer":
            return Text(Array(REAL), f"{RUN}->u")

        return Text(Array(INT if ARRAY[name].buffer == "ints" else REAL, name), _IN_C[name])

    def element(self, array: Text, place: Text) -> Text:
        """A number of an array."""
        shape = array.shape
        assert isinstance(shape, Array), array.text
        text = f"{array.within(8)}[{place.text}]"
        acts = array.acts or place.acts

        if shape.kind == REAL:
            return Text(shapes.ANY_REAL, text, 8, acts)

        if shape.name is None:
            return Text(ANY_INT, text, 8, acts)

        numbers = self._arrays[shape.name][1]

        if isinstance(place.shape, Number) and place.shape.values is not None:
            there = {numbers[k] for k in place.shape.values if 0 <= k < len(numbers)}
        else:
            there = set(numbers)

        # of an array without numbers none is ever read
        return Text(shapes.some(INT, there or {0}), text, 8, acts)

    # calls

    def call(self, caller: Statements, python: FunctionType, args: list[Text]) -> Text:
        """A call of a kernel, of which what is known of the arguments is remembered."""
        made = self._function(python, [arg.shape for arg in args])
        made.callers.add(caller.function)

        for name, arg in zip(made.parameters, args):
            made.learn(name, arg.shape)

        given = [RUN] if made.takes_run else []

        for name, arg in zip(made.parameters, args):
            shape = made.variables[name]

            if isinstance(arg.shape, View):
                continue

            given.append(caller.coerced(arg, shape).text)
            self._pass_on(caller.function, made, name, arg)

        if made.acts:
            caller.function.acts_now()

        if made.returned is None and not made.acts and made.changed:
            return UNKNOWN

        called = self.replaced.get(python, made.name)
        acts = made.acts or any(arg.acts for arg in args)
        return Text(made.returned, f"{called}({', '.join(given)})", 8, acts)

    @staticmethod
    def _pass_on(caller, made, name, arg):
        """An array that is written to by one that it is passed to."""
        if name in made.stores and isinstance(arg.shape, Array) and arg.text in caller.names:
            caller.writes_to(arg.text)

    # the text

    def text(self, wanted: list[Function], beside: str = "") -> tuple[str, str]:
        """(declarations, functions) in C that some need, those that are called first. Raises Untraceable
        where one would call itself.

        beside : C that stands behind them and uses declarations too.
        """
        order: list[Function] = []
        texts: dict[str, str] = {}
        self._visit(wanted, [], order, texts)
        body = "\n\n".join(texts[function.name] for function in order)
        declared = self._declared(f"{body}\n{beside}")

        if any(function.python.__module__.endswith(WIDE) for function in order):
            narrow, wide = KINDS[INT], "int64_t"
            return declared.replace(narrow, wide), body.replace(narrow, wide)

        return declared, body

    def _visit(self, functions, above, order, texts):
        for function in functions:
            if function in above:
                raise Untraceable(f"{function.name} calls itself")

            if function.name not in texts:
                texts[function.name] = text = function.text(self.types)
                inside = words(text.partition("{")[2])
                called = [self._names[word] for word in sorted(inside) if word in self._names]
                self._visit(called, [*above, function], order, texts)
                order.append(function)

    def _declared(self, body):
        """What functions need before them: constants, types, places of arrays."""
        used = words(body)
        parts = [text for name, text in HELPERS.items() if name in used]
        tables = [text for name, text, _ in self.types.tables.values() if name in used]
        arrays = [self._array(name) for name, word in _IN_C.items() if word in used]
        return "\n\n".join(
            [*parts, *_needed(self.types.structures.values(), used), *tables, "\n".join(arrays)]
        ).strip()

    def _array(self, name):
        first, numbers = self._arrays[name]
        buffer = ARRAY[name].buffer

        if buffer == "ints":
            listed = ", ".join(map(constant, numbers or [0]))
            return f"static const int32_t {_IN_C[name]}[{max(1, len(numbers))}] = {{{listed}}};"

        return f"#define {_IN_C[name]} ({RUN}->{buffer} + {first})"


def _needed(structures, used):
    """Definitions of structures that are used, or stand in others that are."""
    found: list[str] = []

    for name, (definition, *at) in reversed(structures):
        taken = [text for text in at if f"{name}_at" in used]

        if taken or name in used:
            used = used.union(*map(words, [definition, *taken]))
            found = [definition, *taken, *found]

    return found


def _arrays_of(ints, counts):
    """Array -> (where it begins in its buffer, its numbers, if these are structure)."""
    found = {}

    for name, array in ARRAY.items():
        first = int(ints[SLOT[name]])
        length = array_length(array, counts)
        found[name] = first, ints[first : first + length].tolist() if array.buffer == "ints" else []

    return found
