"""What a run gave: to files, or a summary to the terminal."""

from ..files import to_standard_output
from .tables import table_of
from .terminal import err, note, out


def show(results, csv, plot, view=None, at=None):
    """Results to files, or a summary to the screen; what the solver had to say of them."""
    note(results.notices)

    # what was written where, unless it came out of the standard output itself
    say = err if any(file and to_standard_output(file) for file in (csv, view)) else out

    if csv:
        say.print(str(results.to_csv(csv)), soft_wrap=True)

    if plot:
        say.print(str(results.plot(plot)), soft_wrap=True)

    if view:
        from ..view.show import show as show_view

        path = show_view(results, view, at, lambda text: note([text]))
        say.print(str(path), soft_wrap=True)

    if not (csv or plot or view):
        _print_summary(results)


def _print_summary(results):
    numbers = ("start", "end", "least", "greatest")
    table = table_of("variable", "unit", *numbers, numbers=numbers)

    for name, column in results.items():
        figures = (column[0], column[-1], column.min(), column.max())
        table.add_row(name, results.units.get(name) or "", *(f"{figure:.6g}" for figure in figures))

    out.print(table)
