"""What a run gives: columns by variable name, to a CSV file or a picture."""

import csv
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ..compiler.variables import array_of, hint, meant
from ..files import check_ending, csv_table, replacing, save_figure
from ..rotations import Rotation
from ..scene import variable_name
from ..scene.errors import listed
from ..units import UNITS
from .states import States


class Results(Mapping):
    """Columns (numpy arrays, one value a row) by variable name; "time" (s) comes first.

    units : unit of each column by name, None for those without.
    notices : what a user should be told: what is odd in the scene, what of its start could not be kept, and,
        with times, what happened in the run, as that the motion became stiff.
    states : of the run, from which the poses of all bodies are found; None of a table from elsewhere.
    """

    def __init__(
        self,
        columns: dict[str, np.ndarray],
        units: dict[str, str | None],
        title: str = "",
        notices: list[str] | None = None,
        states: States | None = None,
    ):
        self._columns = columns
        self.units = units
        self.title = title
        self.notices = notices or []
        self.states = states

    def __getitem__(self, name):
        """A column; an array variable's name without index gives all its components, [row, component].

        Names may be those of an FMU, or written with the scene's names as they are:
        results["Flügel 1.angle"].
        """
        parts = self.known(name)
        whole = parts in ([name], [variable_name(name)])
        return self._columns[parts[0]] if whole else np.column_stack([self._columns[part] for part in parts])

    def known(self, name) -> list[str]:
        """Names of the columns that a name stands for: itself, or the components of an array. Raises
        KeyError.
        """
        if name in self._columns:
            return [name]

        found = variable_name(name) if isinstance(name, str) else name

        if found in self._columns:
            return [found]

        if parts := meant(str(found), self._columns):
            return parts

        raise KeyError(f"no column {name!r}; {hint(str(found), self._columns)}")

    def __iter__(self):
        return iter(self._columns)

    def __len__(self):
        return len(self._columns)

    def __repr__(self):
        return f"<Results of {self.title!r}: {len(self['time'])} rows of {', '.join(self)}>"

    def poses(self, end: str) -> tuple[np.ndarray, np.ndarray]:
        """Where "body", "body.marker" or "ground" was at each row, asked for as an output or not.

        Returns (positions (n, 3) in m, Euler parameters (n, 4), scalar last) in the inertial frame. Raises
        KeyError for what is not there, ValueError for a table that is no run of a scene.
        """
        if self.states is None:
            raise ValueError("these are columns alone, without the states of a run: no poses are known")

        try:
            r, A = self.states.poses([end])
        except KeyError:
            scene = self.states.model.scene
            markers = {"ground": scene.ground.marker} | {
                name: body.marker for name, body in scene.body.items()
            }
            ends = [*markers, "inertial", *(f"{n}.{m}" for n, held in markers.items() for m in held)]
            raise KeyError(f"no body or marker {end!r}; {hint(end, ends)}") from None

        return r[:, 0], Rotation.from_matrix(A[:, 0]).as_quat()

    @classmethod
    def from_csv(cls, path) -> "Results":
        """The columns of a CSV file by name, in SI units, as `to_csv` or a user wrote them; its first row
        holds names, "shoulder.angle" or "shoulder.angle [deg]".

        Raises ValueError with the file's name, row and column.
        """
        names, rows = csv_table(path)

        if not rows:
            raise ValueError(f"{path}: needs a row of names and at least one of numbers")

        columns, units = {}, {}

        for k, heading in enumerate(names):
            name, _, unit = heading.strip().partition(" [")
            unit, factor = _unit(unit.removesuffix("]"))

            if unit is None and factor is None:
                raise ValueError(f"{path}: column {heading!r}: unknown unit; SI units may be left out")

            if name in columns:
                raise ValueError(f"{path}: two columns are called {name!r}")

            cells = [_cell(path, line, row, k, name) for row, line in rows]
            columns[name] = np.array(cells) / factor
            units[name] = unit

        if "time" not in columns:
            raise ValueError(f'{path}: has no column "time" (s); there are {listed(columns)}')

        return cls(columns, units, str(path))

    def to_csv(self, path) -> Path:
        """Write all columns, every digit kept, with a row of names "variable [unit]" on top; "-" is the
        standard output.

        Raises ValueError for a file's ending that promises another format.
        """
        self.check_csv(path)
        names = [f"{name} [{self.units[name]}]" if self.units.get(name) else name for name in self]

        with replacing(path) as temporary, open(temporary, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(names)
            writer.writerows(zip(*(column.tolist() for column in self._columns.values())))

        return Path(path)

    @staticmethod
    def check_csv(path):
        """Raise now the ValueError that `to_csv` would raise later for a file's ending."""
        check_ending(path, "a table of comma-separated values (CSV) is to be written", ".csv", ".txt", ".dat")

    @staticmethod
    def check_plot(path):
        """Raise now what `plot` would raise later: ImportError without matplotlib (extra `plot`), ValueError
        for a file's ending that is no picture's."""
        try:
            from matplotlib.figure import Figure
        except ImportError as error:
            raise ImportError("plots need matplotlib: pip install 'mbdfmi[plot]'") from error

        formats = Figure().canvas.get_supported_filetypes()

        if Path(path).suffix.lstrip(".").lower() not in formats:
            raise ValueError(f"{path}: no picture's name; it ends in .png, .svg or .pdf")

    def plot(self, path) -> Path:
        """Write a picture: one panel for each variable, components of an array together, time below.

        The file's ending chooses the format. Raises ImportError without matplotlib (extra `plot`), ValueError
        for an ending that is no picture's.
        """
        self.check_plot(path)
        figure = self._figure()

        save_figure(figure, path, dpi=130)

        return Path(path)

    def _figure(self):
        """The picture, one panel for each variable."""
        from matplotlib.figure import Figure

        panels = defaultdict(list)

        for name in self:
            if name != "time":
                panels[array_of(name)].append(name)

        n = max(1, len(panels))
        n_column = 1 if n <= 4 else 2
        n_row = -(-n // n_column)
        figure = Figure(figsize=(7 * n_column, 1.2 + 1.9 * n_row), layout="constrained")
        axes = figure.subplots(n_row, n_column, sharex=True, squeeze=False)

        for panel, (name, members) in zip(axes.T.flat, panels.items()):
            self._draw(panel, name, members)

        for panel in list(axes.T.flat)[len(panels) :]:
            panel.set_axis_off()

        for column in range(n_column):
            last = min(n - column * n_row, n_row) - 1
            axes[last, column].set_xlabel("time [s]")
            axes[last, column].tick_params(labelbottom=True)

        figure.suptitle(self.title)
        return figure

    def _draw(self, panel, name, members):
        """One variable, components of an array together."""
        for member in members:
            panel.plot(self["time"], self[member], linewidth=1.2, label=member.removeprefix(name))

        unit = self.units.get(members[0])
        panel.set_title(f"{name} [{unit}]" if unit else name, loc="left", fontsize="medium")
        panel.grid(alpha=0.3)
        panel.ticklabel_format(axis="y", useOffset=False)

        if len(members) > 1:
            panel.legend(loc="upper right", ncols=len(members), fontsize="small")


def _cell(path, line, row, k, name):
    text = line[k].strip() if k < len(line) else ""

    try:
        value = float(text)
    except ValueError:
        value = np.nan

    if not np.isfinite(value):
        raise ValueError(f"{path}: row {row}, column {name!r}: needs a number, found {text!r}")

    return value


def _unit(text):
    """(SI unit, factor of the unit by it) of a unit's name; (None, 1) for none, (None, None) for
    an unknown one.
    """
    if not text or text in UNITS:
        return text or None, 1.0

    for name, unit in UNITS.items():
        for display, factor in unit.display:
            if display == text:
                return name, factor

    return None, None
