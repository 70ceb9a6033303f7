"""What a run gave: to files, or a summary to the terminal."""

from ..files import to_standard_output
from .tables import table_of
from .terminal import err, note, out


def show(results, csv, plot, view=None, at=None):
    """Results to files, or a summary to the screen; what the solver had to say of them."""
    note(results.notices)

    def look(path):
        from ..view.show import show as show_view

        return show_view(results, path, at, lambda text: note([text]))

    write([(csv, results.to_csv), (plot, results.plot), (view, look)])

    if not (csv or plot or view):
        _print_summary(results)


def beside(*files):
    """Where to tell of results: the standard output, but beside it where one of the files is that."""
    return err if any(file and to_standard_output(file) for file in files) else out


def write(files):
    """Writes (path or None, function of a path that returns it), and tells where; the standard output comes
    last: whoever reads it may stop before its end.
    """
    files = [(path, function) for path, function in files if path]
    say = beside(*(path for path, _ in files))

    for path, function in sorted(files, key=lambda pair: to_standard_output(pair[0])):
        say.print(str(function(path)), soft_wrap=True)


def _print_summary(results):
    numbers = ("start", "end", "least", "greatest")
    table = table_of("variable", "unit", *numbers, numbers=numbers)

    for name, column in results.items():
        figures = (column[0], column[-1], column.min(), column.max())
        table.add_row(name, results.units.get(name) or "", *(f"{figure:.6g}" for figure in figures))

    out.print(table)
