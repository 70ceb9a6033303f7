"""The waves of the sea: read, or drawn."""

import numpy as np

from ..hydro.spectra import Components, drawn, of_series, of_spectrum, regular
from ..kernels import outputs
from ..scene import Problem, SceneError
from ..scene.sea import csv_columns
from ..vocabulary import SEA_OUTPUTS
from .builder import Place, Source


def sea_components(scene, parameters=None) -> Components:
    """The components of the sea's waves, read or drawn. Raises SceneError for files that cannot be read.

    parameters : of a run, by name; those of the sea (`SEA_PARAMETERS`) take the place of the scene's.
    """
    waves, given = scene.sea.waves, parameters or {}
    heading = given.get("sea.direction", np.radians(waves.direction_deg))

    if waves.regular:
        spec = waves.regular
        height, period = given.get("sea.height", spec.height), given.get("sea.period", spec.period)
        return regular(height, period, np.radians(spec.phase_deg), heading)

    spec = waves.jonswap or waves.pierson_moskowitz or waves.spectrum

    if spec:
        seed = int(given.get("sea.seed", spec.seed))
        how = spec.components, spec.spacing, seed, heading, spec.spread, spec.directions

        if waves.spectrum:
            omega, energy, hs, tp = _table(spec)
            return of_spectrum(omega, energy, given.get("sea.hs", hs), given.get("sea.tp", tp) / tp, *how)

        gamma = getattr(spec, "gamma", 1.0)
        return drawn(given.get("sea.hs", spec.hs), given.get("sea.tp", spec.tp), gamma, *how)

    kind = "components" if waves.components else "series"
    path = ("sea", "waves", kind, "file")

    try:
        columns = csv_columns(getattr(waves, kind).file, 4 if kind == "components" else 2).T
        return _as_components(kind, columns, heading)
    except ValueError as error:
        raise SceneError([Problem(path, str(error))]) from None


def _table(spec):
    """(omega, energy, significant height, period of the peak) of a file. Raises SceneError."""
    try:
        return spec.table()
    except ValueError as error:
        raise SceneError([Problem(("sea", "waves", "spectrum", "file"), str(error))]) from None


def _as_components(kind, columns, heading):
    """Components of a file's columns. Raises ValueError."""
    if kind == "components":
        if not columns[0].min() > 0.0:
            raise ValueError(f"needs frequencies above 0, found {columns[0].min():g}")
        return Components(*columns)

    steps = np.diff(columns[0])
    if not (steps.min() > 0.0 and np.ptp(steps) < 1e-6 * steps.mean()):
        raise ValueError("needs times that are evenly spaced, ascending")
    return of_series(*columns, heading)


# parameters of a sea in an FMU: their unit, and words
SEA_PARAMETERS = {
    "hs": ("m", "significant height of the waves"),
    "tp": ("s", "period of the spectrum's peak"),
    "height": ("m", "height of the waves from trough to crest"),
    "period": ("s", "period of the waves"),
    "direction": ("rad", "mean direction in which the waves travel, from x towards y"),
    "seed": (None, "seed of the phases, a whole number"),
}


def add_waves(builder):
    """The components of the sea, and the parameters that they are made of, once."""
    if builder.tables["n_sea"].length:
        return

    sea, tables = builder.scene.sea, builder.tables
    waves, spec = sea_components(builder.scene), sea.waves
    drawn = spec.jonswap or spec.pierson_moskowitz or spec.spectrum
    height, period, seed = 1.0, 1.0, -1.0
    names = []

    if drawn:
        height, period = _table(drawn)[2:] if drawn is spec.spectrum else (drawn.hs, drawn.tp)
        seed = drawn.seed
        names = ["hs", "tp", "direction", "seed"]
    elif spec.regular:
        height, period = spec.regular.height, spec.regular.period
        names = ["height", "period", "direction"]

    direction = np.radians(spec.direction_deg) if names else 0.0
    value = [height, period, direction, seed]
    depth, stretched = sea.depth or 0.0, sea.stretching == "wheeler"
    tables["n_sea"].add(sea_value=value, sea_water=[depth, -builder.scene.gravity[2], seed, float(stretched)])

    for omega, amplitude, phase, heading in zip(*waves):
        tables["n_sea_wave"].add(sea_unit=[amplitude / height, omega * period, phase, heading - direction])

    for name in names:
        at = {"hs": 0, "height": 0, "tp": 1, "period": 1, "direction": 2, "seed": 3}[name]
        unit, about = SEA_PARAMETERS[name]
        place = Place("sea_value", 0, at)
        builder.add_parameters(f"sea.{name}", place, value[at], unit, about, "fixed")


def add_sea(builder):
    """Outputs of the sea."""
    sea = builder.scene.sea

    if not (sea and sea.output):
        return

    add_waves(builder)

    for output in sea.output:
        quantity = SEA_OUTPUTS[output]
        source = Source(outputs.ELEVATION, 0, builder.marker("inertial"))
        builder.add_outputs(f"sea.{output}", source, quantity.unit, quantity.text, [])
