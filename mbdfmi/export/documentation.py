"""documentation/index.html: the page that a tool shows for an FMU."""

from collections.abc import Iterable

from lxml import html
from lxml.builder import E

from ..steppers import STEPPERS
from .description import REST, generation_time, start_of_rest, tool_version

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1c2b3a; max-width: 62em; margin: 2em auto }
h1 { margin-bottom: 0 } h2 { margin-top: 2em; border-bottom: 1px solid #cfd9e2 }
.title { font-size: 1.15em; color: #4a6072; margin-top: 0 }
table { border-collapse: collapse; width: 100% }
th, td { text-align: left; vertical-align: top; padding: .25em .8em .25em 0 }
tr { border-bottom: 1px solid #e6ecf1 }
code { font-size: .92em }
"""

_HEADINGS = {
    "input": (
        "Inputs",
        "Held over a communication step; in FMI 2 polynomials of time when the master gives derivatives.",
    ),
    "output": (
        "Outputs",
        "Values at the communication point.",
    ),
    "parameter": (
        "Parameters",
        "Tunable ones may be changed between steps, fixed ones before the simulation.",
    ),
    "constant": (
        "Constants",
        "Parameters that are bound: nobody can change them.",
    ),
}


_DISCARDED = {
    2: "A step that cannot be completed returns fmi2Discard with the time reached (fmi2LastSuccessfulTime) and fmi2Terminated",
    3: "A step that cannot be completed returns fmi3Discard and leaves the FMU as it was before",
}


def documentation(model, platforms: Iterable[str], fmi: int, picture: str | None = None) -> bytes:
    """The page, UTF-8, of a model whose FMU is made for the given platforms and version of FMI; picture: a file beside it."""
    page = E.html(
        E.head(E.meta(charset="utf-8"), E.title(model.name), E.style(_STYLE)),
        E.body(
            E.h1(model.name),
            *([E.p(model.title, {"class": "title"})] if model.title != model.name else []),
            *([E.p(model.description)] if model.description else []),
            *([E.img({"src": picture, "alt": f"{model.name} at its start"})] if picture else []),
            *_what_it_is(model, platforms, fmi),
            *_contents(model.scene),
            *(section for causality in _HEADINGS for section in _variables(model, causality)),
            *_use(fmi),
        ),
        lang="en",
    )
    return html.tostring(page, doctype="<!DOCTYPE html>", encoding="utf-8", pretty_print=True)


def _what_it_is(model, platforms, fmi) -> list:
    facts = {
        "Kind": f"FMI {fmi}.0, {'model exchange and ' if model.exchanges else ''}co-simulation",
        "Platforms": ", ".join(platforms),
        "Needs": "the C library of the platform, nothing else",
        "Solver": _solver(model.scene.solver),
        "GUID": model.guid,
        "Made by": f"mbdfmi {tool_version()}, {generation_time():%Y-%m-%d}",
    }
    return [
        E.h2("What this is"),
        E.p("A rigid multibody system with its own solver. Units are SI, angles are radians, "
            "orientations are Euler parameters with the scalar part last."),
        E.table(*(E.tr(E.th(name), E.td(text)) for name, text in facts.items())),
    ]  # fmt: skip


def _contents(scene) -> list:
    """Tables of bodies, joints and forces."""
    bodies = []
    for name, body in scene.body.items():
        mass, com, _ = body.mass_properties()
        bodies.append([name, f"{mass:.6g}", ", ".join(f"{x:.6g}" for x in com)])

    joints = [[name, j.kind, " to ".join(j.between)] for name, j in scene.joint.items()]
    forces = [[name, f.kind.replace("_", "-"), " to ".join(f.between)] for name, f in scene.force.items()]

    return [
        *_section("Bodies", ["Name", "Mass, kg", "Centre of mass, m"], bodies),
        *_section("Joints", ["Name", "Kind", "Between"], joints),
        *_section("Forces", ["Name", "Kind", "Between"], forces),
    ]


def _section(heading: str, head: list[str], rows: list[list], text: str = "") -> list:
    """A heading, a text and a table; nothing when it has no rows."""
    if not rows:
        return []

    table = E.table(E.tr(*map(E.th, head)), *(E.tr(*map(E.td, row)) for row in rows))
    return [E.h2(heading), *([E.p(text)] if text else []), table]


def _variables(model, causality: str) -> list:
    """The table of the variables of one causality."""
    heading, text = _HEADINGS[causality]
    head = ["Name", "Unit", "Description"]
    variables = model.of_causality(causality)
    rows = [[E.code(v.name), v.unit or "", v.description] for v in variables]

    if causality in ("parameter", "constant"):
        head += ["Value", "Variability"]
        for row, v in zip(rows, variables):
            row += [f"{v.start:.10g}", v.variability]

    if causality == "parameter" and model.rest:
        rows.append([E.code(REST["name"]), "", REST["description"], start_of_rest(model), "fixed"])

    return _section(heading, head, rows, text)


def _solver(solver) -> str:
    """The solver in a sentence."""
    words = STEPPERS[solver.integrator].words
    method = words[0].upper() + words[1:]

    if solver.fixed_step:
        return f"{method}, inner steps of at most {solver.step:g} s."

    return (
        f"{method}, adaptive inner steps, relative tolerance {solver.tolerance:g}, "
        f"absolute tolerance {solver.absolute_tolerance:g}."
    )


def _use(fmi) -> list:
    return [
        E.h2("Use"),
        E.ul(
            E.li("Any communication step size, also changing from step to step; the solver takes "
                 "its own steps inside it."),
            E.li("The state can be saved, restored and serialised; a restored run repeats to the "
                 "last bit."),
            E.li("Several instances may run in one process, in different threads."),
            E.li(_DISCARDED[fmi] + "; the log says why and where."),
        ),
        E.h2("Licence"),
        E.p("The library in this FMU is part of mbdfmi, BSD 2-Clause licence, and comes without "
            "any warranty. The model in it belongs to whoever wrote its scene."),
    ]  # fmt: skip
