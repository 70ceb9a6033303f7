"""Eigenvalues against a parameter: the root locus."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import scipy  # which imports its parts when they are asked for

from ..files import check_ending, save_figure
from .linear import about
from .manifold import AUTO, Manifold
from .places import AT_REST, START, mechanism_of, rests, state_at
from .starting import starting


@dataclass(frozen=True)
class Locus:
    """Eigenvalues against a parameter.

    name, unit : of the parameter. values : (n,). eigenvalues : (n, k) 1/s, NaN where there is none; a column
    goes on as one root. notices : what a user should be told.
    """

    name: str
    unit: str | None
    values: np.ndarray
    eigenvalues: np.ndarray
    title: str
    notices: list[str] = field(default_factory=list)

    def crossings(self) -> list[tuple[float, complex]]:
        """Where a root comes to grow, or to die away: [(value of the parameter, eigenvalue there)], between
        the values looked at by a straight line.
        """
        found = []

        for root in self.eigenvalues.T:
            real = root.real

            for k in range(len(root) - 1):
                if np.isfinite(real[k : k + 2]).all() and real[k] * real[k + 1] < 0.0 and root[k].imag >= 0.0:
                    part = real[k] / (real[k] - real[k + 1])
                    value = self.values[k] + part * (self.values[k + 1] - self.values[k])
                    found.append((float(value), complex(root[k] + part * (root[k + 1] - root[k]))))

        return sorted(found, key=lambda pair: pair[0])

    def to_csv(self, path) -> Path:
        """Write a table: the parameter, then real and imaginary part of each root. Returns the path."""
        from ..run.results import Results

        columns = {"time": self.values}
        units = {"time": self.unit}

        for k, root in enumerate(self.eigenvalues.T, 1):
            columns |= {f"root[{k}].real": root.real, f"root[{k}].imag": root.imag}

        table = Results({self.name: columns.pop("time")} | columns, units | {self.name: self.unit})
        return table.to_csv(path)

    def plot(self, path) -> Path:
        """Draw the roots, in the complex plane and by the parameter (png, svg, pdf). Returns the path."""
        from matplotlib.figure import Figure

        path = Path(path)
        check_ending(path, "a picture is to be drawn", ".png", ".svg", ".pdf")
        figure = Figure(figsize=(12, 5.4), layout="constrained")
        plane, parts = figure.subplots(1, 2)
        self._draw_plane(figure, plane)
        label = f"{self.name} [{self.unit}]" if self.unit else self.name

        for root in self.eigenvalues.T:
            (line,) = parts.plot(self.values, root.real, linewidth=1.4)

            if np.nanmax(root.imag, initial=0.0) > 0.0:
                parts.plot(self.values, root.imag, linewidth=1.0, linestyle="--", color=line.get_color())

        parts.axhline(0.0, color="black", linewidth=0.8)
        parts.set_xlabel(label)
        parts.set_title("real (solid) and imaginary (dashed) parts [1/s]", loc="left", fontsize="medium")
        parts.grid(alpha=0.3)
        figure.suptitle(self.title)

        save_figure(figure, path, dpi=150)

        return path

    def _draw_plane(self, figure, plane):
        for root in self.eigenvalues.T:
            plane.plot(root.real, root.imag, color="0.8", linewidth=0.8, zorder=1)

        every = np.broadcast_to(self.values[:, None], self.eigenvalues.shape)
        dots = plane.scatter(
            self.eigenvalues.real, self.eigenvalues.imag, c=every, cmap="viridis", s=14, zorder=2
        )
        first = self.eigenvalues[0]
        plane.scatter(first.real, first.imag, marker="x", color="black", s=34, zorder=3, label="first value")
        plane.axvline(0.0, color="black", linewidth=0.8)
        plane.set_xlabel("real part [1/s]")
        plane.set_ylabel("imaginary part [1/s]")
        plane.set_title("eigenvalues", loc="left", fontsize="medium")
        plane.grid(alpha=0.3)
        plane.legend(loc="best", fontsize="small")
        figure.colorbar(dots, ax=plane, label=f"{self.name} [{self.unit}]" if self.unit else self.name)


def locus(
    scene,
    name: str,
    values,
    at=None,
    *,
    axes: str = AUTO,
    hold=None,
    parameters=None,
    progress: Callable[[str], None] | None = None,
) -> Locus:
    """Eigenvalues of a scene over values of a parameter or an input, by its variable's name; the others as
    `linearise` takes them. Where there is an equilibrium for some values, those without one are left out;
    where the scene starts moving for some, all are about the start.
    """
    values = np.asarray(values, float)
    mechanism = mechanism_of(scene, hold, parameters)
    variables = {v.name: v for v in mechanism.model.variables}
    is_input = name in variables and variables[name].causality == "input"
    if at is None:
        at = _one_kind(scene, mechanism, name, values, is_input, hold, parameters)

    every: list = []
    places: list[str] = []
    notices: list[list[str]] = []

    for k, value in enumerate(values.tolist()):
        if progress:
            progress(f"{name} = {value:g} ({k + 1} of {len(values)})")

        held = (hold or {}) | ({name: value} if is_input else {})
        changed = (parameters or {}) | ({} if is_input else {name: value})

        if scene.solver.start == "trim":
            start = starting(scene, held, changed)
            found, where, told = state_at(start.scene, at, start.hold, start.parameters)
        else:
            found, where, told = state_at(scene, at, held, changed, like=mechanism)

        modes = about(Manifold(found, axes), [], [], told).modes()
        every.append(modes.eigenvalues[len(modes.free) :])
        places.append(where)
        notices.append([f"{name} = {value:g}: {text}" for text in modes.linear.notices])

    # one curve is about one kind of state
    left = [k for k, where in enumerate(places) if where != AT_REST and AT_REST in places]
    every = [roots[:0] if k in left else roots for k, roots in enumerate(every)]
    told = list(dict.fromkeys(text for k, texts in enumerate(notices) if k not in left for text in texts))
    told = told if len(told) <= 4 else [*told[:3], f"and {len(told) - 3} more of this kind"]

    if left:
        some = ", ".join(f"{values[k]:g}" for k in left[:6]) + (", …" if len(left) > 6 else "")
        told.append(f"{name} = {some}: left out, for there is no equilibrium")

    unit = variables[name].unit if name in variables else None
    return Locus(name, unit, values, _followed(every), mechanism.model.title, told)


def _one_kind(scene, mechanism, name, values, is_input, hold, parameters):
    """The start, where that moves for one of the values at least; else None."""
    if scene.solver.start == "trim":
        return None

    for value in values.tolist():
        held = (hold or {}) | ({name: value} if is_input else {})
        changed = (parameters or {}) | ({} if is_input else {name: value})

        if not rests(mechanism_of(scene, held, changed, like=mechanism)):
            return START

    return None


def _followed(every):
    """Roots (n, k) of lists of roots, each column from value to value the nearest one, NaN where there is
    none.
    """
    width = max((len(roots) for roots in every), default=0)
    found = np.full((len(every), width), np.nan, complex)
    last = np.zeros(width, complex)
    known = np.zeros(width, bool)
    slope = np.zeros(width, complex)

    for k, roots in enumerate(every):
        if not len(roots):
            continue

        guess = last + slope
        cost = np.where(known[None, :], np.abs(roots[:, None] - guess[None, :]), 1e6)
        rows, columns = scipy.optimize.linear_sum_assignment(cost)
        found[k, columns] = roots[rows]
        slope[columns] = np.where(known[columns], roots[rows] - last[columns], 0.0)
        last[columns] = roots[rows]
        known[columns] = True

    return found
