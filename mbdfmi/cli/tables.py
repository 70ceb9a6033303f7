"""Tables and numbers on the terminal."""

from .terminal import out


def table_of(*headings, numbers=()):
    """A table with plain rules; `numbers` are the headings of columns set flush right.

    The first column holds names, which stay whole; others wrap where the terminal is narrow.
    """
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0), show_edge=False)

    for k, heading in enumerate(headings):
        table.add_column(heading, justify="right" if heading in numbers else "left", no_wrap=k == 0)

    return table


def print_table(table):
    out.print()
    out.print(table)


def count(n, one, many=None):
    return f"{n} {one if n == 1 else many or one + 's'}"


def vector(values):
    return ", ".join(f"{value:.6g}" for value in values)
