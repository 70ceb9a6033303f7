"""layout.h: what the C wrapper knows of the package, written from the package's own tables when a library is
linked.

No place in a buffer, no size, code or name that both languages use is written down twice.
"""

import inspect
import re
from collections.abc import Iterable

from ..compiler.model import SEALED_SIZES
from ..compiler.variables import KINDS, TABLE
from ..kernels import entry, layout, loops, prepare, signatures, status, views
from ..kernels.forces import solutions
from ..kernels.language import APART
from ..kernels.motion.inputs import N_DERIVATIVE
from ..native.library import TABLE as TABLE_NAME
from ..trace.solutions import COUNTED
from . import resource, tape
from .description import LOG_CATEGORIES

NAME = "layout.h"

_BUFFERS = ("ints", "reals", "state", "work")
_CODES = ("OK", "STIFF", "NOT_STIFF", "OUTPUT_NOT_FINITE")  # that the wrapper treats in a way of its own
_TYPES = {signatures.int64: "int64_t ", signatures.float64: "double ", signatures.REALS: "double *"}
_VIEWS = {signatures.MODEL: ("m", views.ModelView), signatures.DATA: ("d", views.DataView)}


def layout_header(names: str = "") -> str:
    """The text of layout.h. names : definitions of what names of the wrapper stand for."""
    parts = [_arrays(), _statuses(), _entries(), _resource(), _tape(), _log()]
    return "\n\n".join(
        [
            f"/* Written by {__name__} when a library is linked: what C knows of the package. */",
            "#ifndef MBDFMI_LAYOUT_H\n#define MBDFMI_LAYOUT_H\n\n#include <stdint.h>",
            *([names] if names else []),
            *parts,
            "#endif\n",
        ]
    )


def table_of_kernels(names: Iterable[str] | None = None, guid: str = "") -> str:
    """The text of a C file: a table of kernels, by which a process that loads the library calls them.

    names : of the kernels, by default all that stand apart. guid : of the one model that the library is for,
    if it is.

    One symbol, not one for each kernel: those of two libraries in a process cannot be taken for each other.
    """
    assert loops  # all that stand apart are there once it is
    names = sorted(APART if names is None else names)
    declared = "\n".join(f"void {name}(void);" for name in names)
    rows = "\n".join(f'    {{"{name}", {name}}},' for name in names)
    return f"""/* Written by {__name__} when a library is linked. */
#ifdef _WIN32
#define SHOWN __declspec(dllexport)
#else
#define SHOWN __attribute__((visibility("default")))
#endif

/* The GUID of the one model that this library is for; empty: for all. */
extern const char mbdfmi_only_guid[];
const char mbdfmi_only_guid[] = "{guid}";

/* Of whatever signature: native/library.py knows them. */
{declared}

typedef struct {{
    const char *name;
    void (*kernel)(void);
}} Row;

extern const Row {TABLE_NAME}[];
SHOWN const Row {TABLE_NAME}[] = {{
{rows}
    {{0, 0}},
}};
"""


def _enum(names: Iterable[str], first: int = 0) -> str:
    """An enumeration that counts from `first`."""
    lines = [f"    {name}{f' = {first}' if k == 0 else ''},\n" for k, name in enumerate(names)]
    return "enum {\n" + "".join(lines) + "};"


def _arrays() -> str:
    """Counts, places and lengths of the arrays (kernels/layout.py)."""
    counts = _enum([*(f"COUNT_{name}" for name in layout.COUNTS), "N_COUNT"])
    places = _enum([*(f"AT_{row.name}" for row in layout.ARRAYS), "HEADER_LENGTH"], len(layout.COUNTS))
    rows = []

    for row in layout.ARRAYS:
        fixed = isinstance(row.count, int)
        width = row.width * row.count if fixed else row.width
        count = "ONCE" if fixed else f"COUNT_{row.count}"
        rows.append(f'    {{"{row.name}", {width}, {count}, IN_{row.buffer.upper()}}},\n')

    longest = max(len(row.name) for row in layout.ARRAYS)
    assert all(row.width * (row.count if isinstance(row.count, int) else 1) < 2**15 for row in layout.ARRAYS)

    return f"""/* The head of ints: a model's counts ... */
{counts}

/* ... then the offset of each array in its buffer. */
{places}

typedef enum {{ {", ".join(f"IN_{name.upper()}" for name in _BUFFERS)}, N_BUFFER }} Buffer;

/* The name stands in the row itself: a loader has no addresses to fill in. */
typedef struct {{
    char name[{longest + 1}];
    int16_t width;                    /* numbers for each of the count */
    int16_t count;                    /* where the count stands, or ONCE */
    uint8_t buffer;
}} Array;

#define ONCE (-1)

#ifndef MBDFMI_ONE_SCENE
/* The arrays, in the order of their offsets. */
static const Array ARRAYS[HEADER_LENGTH - N_COUNT] = {{
{"".join(rows)}}};
#endif"""


def _statuses() -> str:
    """What a status and a notice are (kernels/status.py), and how many derivatives inputs have."""
    codes = "".join(f"    CODE_{name} = {getattr(status, name)},\n" for name in _CODES)
    return f"""/* A status is code + PLACE*place. */
#define PLACE {status.status(0, 1)}
enum {{
{codes}}};

/* Each notice is a status and the numbers of its text. */
#define MOST_NOTICES {status.MOST_NOTICES}
#define NOTICE_WIDTH {layout.ARRAY["notice"].width}

/* Inputs are values and their derivatives, n_u of each. */
#define N_DERIVATIVE {N_DERIVATIVE}

/* Between which a tolerance must be. */
#define LEAST_TOLERANCE {prepare.LEAST_TOLERANCE!r}
#define LARGEST_TOLERANCE {prepare.LARGEST_TOLERANCE!r}"""


def _entries() -> str:
    """Prototypes of the compiled kernels (kernels/entry.py), and the buffers that they take for m and d."""
    lines = []

    for name, view in _VIEWS.values():
        buffers = ", ".join(f"(c)->{buffer}" for buffer in view.buffer_names)
        lines.append(f"#define {name.upper()}_OF(c) {buffers}\n")

    lines += [f"\n{prototype(name)};\n" for name in entry.ENTRIES]
    lines.append("\n/* The GUID of the one model that the library is for; empty: for all. */\n")
    lines.append("extern const char mbdfmi_only_guid[];\n")
    return f"/* Entries of the kernels; see kernels.h. */\n{''.join(lines)}".rstrip()


def prototype(name: str) -> str:
    """An entry as C declares it."""
    kernel = entry.ENTRIES[name]
    signature = kernel.signature
    given = inspect.signature(kernel).parameters
    arguments = [_argument(kind, argument) for kind, argument in zip(signature.args, given)]
    result = f"{_TYPES[signature.return_type]}*status"
    return f"int32_t {name}({', '.join([result, 'void **excinfo', *arguments])})"


def _argument(kind, name: str) -> str:
    """An argument of an entry, as C takes it."""
    if kind not in _VIEWS:
        return f"{_TYPES[kind]}{name}"

    name, view = _VIEWS[kind]
    return ", ".join(
        f"const int64_t *{name}_{buffer}" if buffer == "ints" else f"double *{name}_{buffer}"
        for buffer in view.buffer_names
    )


def _resource() -> str:
    """The parts of model.bin (resource.py) that have names in both languages."""
    magic = "".join(f"\\{byte:03o}" for byte in resource.MAGIC)
    kinds = _enum([*(f"VARIABLE_{kind.upper()}" for kind in KINDS), "N_KIND"])
    return f"""/* The resource file; see resource.h. */
#define RESOURCE_NAME "{resource.NAME}"
#define RESOURCE_MAGIC "{magic}"
#define RESOURCE_VERSION {resource.VERSION}
#define GUID_SIZE {resource.GUID_SIZE}

/* Its sizes, and how many of them the GUID is made of. */
typedef struct {{
    int64_t {", ".join(resource.SIZES)};
}} Sizes;

#define N_SEALED {len(SEALED_SIZES)}

/* What a value reference is. */
{kinds}

typedef struct {{
    int64_t {", ".join(TABLE.names or ())};
}} Variable;"""


def _tape() -> str:
    """Operations of the tape (tape.py), the buffers that its leaves stand in, and what kernels solve for in it."""
    rows = ", ".join(
        f"{{{takes}, {gives}, COUNT_{count}}}" for (takes, gives), count in zip(solutions.WIDTHS, COUNTED)
    )
    return f"""/* Operations of the tape; see tape.h. */
{_enum([*(f"TAPE_{name}" for name in tape.OPERATIONS.values()), "N_OPERATION"])}

{_enum([*(f"LEAF_{name.upper()}" for name in tape.BUFFERS), "N_LEAF_BUFFER"])}

/* Numbers that are taken and given by what mbdfmi_solve knows, and where it stands how many there are. */
typedef struct {{
    int16_t takes, gives, count;
}} Solution;

#define N_SOLUTION {solutions.N_KIND}

static const Solution SOLUTIONS[N_SOLUTION] = {{{rows}}};"""


def _log() -> str:
    """Categories of the log (description.py): logStatusError is LOG_STATUS_ERROR."""
    names = [re.sub("[A-Z]", lambda found: "_" + found[0], name).upper() for name in LOG_CATEGORIES]
    quoted = ", ".join(f'"{name}"' for name in LOG_CATEGORIES)
    return f"""/* Categories of the log. */
{_enum([*names, "N_CATEGORY"])}

static const char *const CATEGORY_NAMES[N_CATEGORY] = {{{quoted}}};"""
