"""mbdfmi info: what a scene holds."""

import re
from itertools import groupby

from ..arguments import add_command, add_scene
from ..paths import load_scene
from ..tables import count, print_table, table_of, vector
from ..terminal import doing_here, err, note, out

# what a user cannot have written
FORMULATIONS = {
    "apart": 'bodies apart, chosen as loops stand in a row; "recursive" would keep joint coordinates'
}


def add(commands):
    """The command and its arguments."""
    command = add_command(
        commands,
        run,
        "info",
        "show what a scene holds",
        "Bodies, joints, degrees of freedom, solver, and the variables that its FMU will have.",
    )
    add_scene(command)
    command.add_argument("--parameters", action="store_true", help="list the parameters and their values too")


def run(options):
    """Prints it all."""
    scene = load_scene(options.scene, options)
    model = scene.compile()
    found, notices = _structure(options.scene, scene, model)
    _print_heading(scene, model, found)
    _print_bodies(scene)
    _print_joints(scene)
    _print_forces(scene)

    if found:
        _print_structure(found)

    for causality in ("input", "output", "parameter")[: 3 if options.parameters else 2]:
        _print_variables(causality, model.of_causality(causality))

    note(notices)


def _print_heading(scene, model, found):
    """Name, description and what can be said in a line each."""
    out.print(model.title, style="bold")

    if model.description:
        out.print(model.description.strip())

    n_parts = len({node for node, _ in model.tree.home.values() if node})
    bodies = count(len(scene.body), "body", "bodies")
    bodies += f" in {count(n_parts, 'rigid part')}" if n_parts < len(scene.body) else ""
    out.print(f"{bodies}, {count(found.freedom, 'degree')} of freedom" if found else bodies)
    kinds = ("input", "output", "parameter")
    out.print(", ".join(count(len(model.of_causality(kind)), kind) for kind in kinds))
    central = scene.central_gravity
    out.print(
        f"gravity {f'central, mu {central.mu:g} m3/s2' if central else f'{vector(scene.gravity)} m/s2'}"
    )
    out.print(f"solver {_solver(scene.solver)}")
    out.print(f"formulation {FORMULATIONS.get(model.formulation, model.formulation)}")


def _print_bodies(scene):
    table = table_of("body", "mass, kg", "centre of mass, m", "markers", numbers=("mass, kg",))

    for name, body in scene.body.items():
        mass, com, _ = body.mass_properties()
        table.add_row(name, f"{mass:.6g}", vector(com), ", ".join(body.marker))

    print_table(table)


def _print_joints(scene):
    table = table_of("joint", "kind", "from", "to", "freedoms", numbers=("freedoms",))

    for name, joint in scene.joint.items():
        table.add_row(name, joint.kind, *joint.between, str(len(joint.start_velocity())))

    print_table(table)


def _print_forces(scene):
    if scene.force:
        table = table_of("force", "kind", "from", "to")

        for name, force in scene.force.items():
            table.add_row(name, force.kind.replace("_", "-"), *force.between)

        print_table(table)


def _structure(path, scene, model):
    """The scene's Structure, and notices of its start; None, and why, where its loops cannot be closed."""
    from ...run.instance import Instance, SimulationError

    with doing_here(f"{path}: looking at its freedoms"):
        try:
            return scene.structure(), Instance(model).notices
        except SimulationError as error:
            err.print(f"{path}: its freedoms cannot be counted: {error}", soft_wrap=True)
            return None, model.notices


def _print_structure(found):
    """Where the degrees of freedom come from, and what is not determined."""
    if found.equations or found.driven:
        out.print(
            f"\n{count(found.coordinates, 'joint coordinate')} less "
            f"{count(found.rank, 'independent equation')} (of {found.equations}): "
            f"{count(found.freedom, 'degree')} of freedom"
        )

    if found.freedom_at_start > found.freedom:
        out.print(f"the start is singular: {count(found.freedom_at_start, 'degree')} of freedom there")

    for text, names in (("driven", found.driven), ("closing loops", found.closing)):
        if names:
            out.print(f"{text}: {', '.join(names)}")

    for heading, rows in (
        ("equation that follows from others", [(row.owner, row.keeps) for row in found.redundant]),
        ("reaction not determined", [(row.owner, row.what) for row in found.undetermined]),
    ):
        if rows:
            table = table_of("joint", heading)

            for row in rows:
                table.add_row(*row)

            print_table(table)


def _solver(solver):
    if solver.step:
        return f"{solver.integrator}, fixed step of at most {solver.step:g} s"

    limit = f", steps of at most {solver.max_step:g} s" if solver.max_step else ""
    tolerances = f"tolerance {solver.tolerance:g} relative, {solver.absolute_tolerance:g} absolute"
    return f"{solver.integrator}, adaptive step, {tolerances}{limit}"


def _print_variables(causality, variables):
    """A table of variables, an array in one row."""
    from ...compiler.variables import array_of

    if not variables:
        out.print(f"\nno {causality}s")
        return

    values = ("value",) if causality == "parameter" else ()
    # a narrow terminal shows values instead
    meanings = ("meaning",) if not values or out.width >= 110 else ()
    table = table_of(causality, *values, "unit", *meanings)

    for base, group in groupby(variables, lambda v: array_of(v.name)):
        members = list(group)
        name = base + re.sub(r"\d+", r"1..\g<0>", members[-1].name.removeprefix(base))
        units = list(dict.fromkeys(v.unit for v in members if v.unit))
        unit = units[0] + ", ..." * (len(units) > 1) if units else ""
        cells = [_values([v.start for v in members])] if values else []
        table.add_row(name, *cells, unit, *([members[0].description] if meanings else []))

    print_table(table)


def _values(numbers):
    if len(numbers) <= 6:
        return vector(numbers)

    return f"{len(numbers)} numbers, {sum(number != 0.0 for number in numbers)} not zero"
