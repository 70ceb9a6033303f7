"""The sea: its water, its waves; and bodies that linear potential theory knows."""

from typing import Annotated, ClassVar

import numpy as np
from pydantic import BeforeValidator, Field, PlainValidator, model_validator

from ..files import csv_table
from ..vocabulary import HYDRODYNAMICS_OUTPUTS, MEMBER_OUTPUTS, SEA_OUTPUTS
from .ends import Between, Ends
from .errors import show
from .fields import (
    Boolean,
    NotNegative,
    Number,
    OneOf,
    Part,
    Positive,
    SomeOf,
    Vector,
    array,
    number,
    number_or,
)
from .meshes import MeshFile


def data_file(value, info):
    """The type's validator of a file of numbers: relative names start at the folder of the scene file."""
    if isinstance(value, MeshFile):
        return value
    if not isinstance(value, str) or not value.strip():
        raise ValueError(f"needs the name of a file in quotes, found {show(value)}")
    return MeshFile(value, (info.context or {}).get("folder", "."))


DataName = Annotated[MeshFile, PlainValidator(data_file)]


def whole(least, most):
    """The type of a whole number."""

    what = f"whole number from {least} to {most}"

    def check(value):
        if number(value) != int(value) or not least <= value <= most:
            raise ValueError(f"must be a {what}, found {show(value)}")
        return int(value)

    return Annotated[int, BeforeValidator(check)]


Count = whole(1, 10_000)
Seed = whole(0, 2**32 - 1)
States = whole(2, 60)


class RegularWaves(Part):
    """height : m, from trough to crest. period : s. phase_deg : of the elevation height / 2 cos(2 pi t / period + phase) at the origin."""

    height: Positive
    period: Positive
    phase_deg: Number = 0.0


class Drawn(Part):
    """Components of random phases.

    components : their number.
    spacing : "energy", components of equal energy, "frequency", in bands of equal width.
    spread, directions : s of cos^(2 s)(angle / 2) about the mean direction, over so many directions; left out, all travel one way.
    seed : of the phases; another one is another sea of the same spectrum.
    """

    components: Count = 200
    spacing: OneOf("energy", "frequency") = "energy"
    spread: Positive | None = None
    directions: Count = 11
    seed: Seed = 1


class Spectrum(Drawn):
    """A sea of random phases whose energy is that of hs exactly.

    hs : significant height, m. tp : period of the peak, s.
    """

    hs: Positive
    tp: Positive


class SpectrumFile(Drawn):
    """A sea of random phases of any spectrum, as of a measured one; its height and the period of its peak are parameters of the FMU.

    file : CSV with a line of names, then omega (rad/s, ascending, above 0) and energy (m2 s/rad), straight between; none outside.
    """

    file: DataName = Field(description='as in file = "spectrum.csv"')

    def table(self):
        """(omega (n,) rad/s, energy (n,) m2 s/rad, significant height m, period of the peak s). Raises ValueError."""
        omega, energy = csv_columns(self.file, 2).T

        if not (omega[0] > 0.0 and np.diff(omega).min() > 0.0):
            raise ValueError(f"{self.file.path}: needs frequencies (rad/s) above 0, ascending")
        if energy.min() < 0.0 or not energy.max() > 0.0:
            raise ValueError(
                f"{self.file.path}: needs energies (m2 s/rad) that are not negative, and not all 0"
            )

        height = 4.0 * float(np.sqrt(np.trapezoid(energy, omega)))
        return omega, energy, height, float(2 * np.pi / omega[energy.argmax()])


class Jonswap(Spectrum):
    """gamma : how much its peak stands out; 1 is Pierson and Moskowitz's."""

    gamma: Positive = 3.3


class WaveSeries(Part):
    """A measured elevation, over and over.

    file : CSV with a line of names, then time (s, evenly spaced) and elevation (m) at the origin.
    """

    file: DataName = Field(description='as in file = "elevation.csv"')


class WaveComponents(Part):
    """file : CSV with a line of names, then omega (rad/s), amplitude (m), phase (rad), direction (rad): elevation at the origin is
    the sum of amplitude cos(omega t + phase)."""

    file: DataName = Field(description='as in file = "components.csv"')


class Waves(Part):
    """The waves of a sea, long before the bodies are there. `mbdfmi sea SCENE` tells their heights and periods, and writes them.

    direction_deg : the way they travel, from x towards y; not of components.
    """

    needed: ClassVar[tuple] = (
        ("regular", "jonswap", "pierson_moskowitz", "spectrum", "components", "series"),
    )

    regular: RegularWaves | None = None
    jonswap: Jonswap | None = None
    pierson_moskowitz: Spectrum | None = None
    spectrum: SpectrumFile | None = None
    components: WaveComponents | None = None
    series: WaveSeries | None = None
    direction_deg: Number = 0.0


class Current(Part):
    """velocity : (3,) m/s at the surface, in the inertial frame.
    exponent : of the power law ((depth + z) / depth)^exponent by which it falls towards the bed; 0: the same all the way.
    """

    velocity: Vector = Field(description="velocity [x, y, z] in m/s")
    exponent: NotNegative = 0.0


class Sea(Part):
    """Water that fills z < 0 of the inertial frame, z up. Without this table what floats does so in sea water at rest.

    density : kg/m3.
    depth : m, of a flat bed; deep when left out.
    current : that drags at members; none when left out.
    waves : that bodies with `hydrodynamics`, and members, feel; none when left out.
    stretching : how the water moves above the mean surface at members: "wheeler", up to the waves as it does under the mean surface,
        "none", as it does there, and members are wet up to z = 0.
    output : elevation of the undisturbed sea at the origin, m.
    """

    density: Positive = 1025.0
    depth: Positive | None = None
    current: Current | None = None
    waves: Waves | None = None
    stretching: OneOf("wheeler", "none") = "none"
    output: SomeOf(*SEA_OUTPUTS) = []

    @model_validator(mode="after")
    def _check_output(self):
        if "stretching" in self.model_fields_set and not self.waves:
            raise ValueError("stretching is about waves, and there are none")
        if self.output and not self.waves:
            raise ValueError('output "elevation" is that of waves, and there are none')
        if self.current and self.current.exponent and not self.depth:
            raise ValueError("a current that falls towards the bed needs a depth")
        return self


class RadiationOptions(Part):
    """error : of the memory, by the peak of each motion; it gets as many states as that takes.
    states : so many instead, for each group of motions that are coupled.
    file : a ready model in states instead (.ss, as SS_Fitting writes it), in SI, of force and motion about the same point.
    """

    exclusive = (("error", "states", "file"),)

    error: Positive | None = None
    states: States | None = None
    file: DataName | None = None


def _numbers(value):
    """Numbers of different bodies, from 1."""
    if not isinstance(value, (list, tuple)) or not value:
        raise ValueError(f"needs a list of numbers of bodies, as in bodies = [2]; found {show(value)}")

    for k, item in enumerate(value):
        if number(item) != int(item) or item < 1:
            raise ValueError(f"numbers of bodies are whole, from 1; found {show(item)}")
        if item in value[:k]:
            raise ValueError(f"body {show(item)} is listed twice")
    return tuple(int(item) for item in value)


def _feels(value):
    """true, false or "input"."""
    if isinstance(value, bool) or value == "input":
        return value
    raise ValueError(f'needs true, false or "input", found {show(value)}')


Excitation = Annotated[bool | str, BeforeValidator(_feels)]


def _for_each(*shapes, what):
    """The type of an array, or of a list of such arrays, one for each body."""

    def check(value):
        if isinstance(value, np.ndarray):
            value = value.tolist()
        try:
            return array(value, *shapes, what=what)
        except ValueError:
            depths = [_depth(item) for item in value] if isinstance(value, (list, tuple)) else [0]
            if min(depths, default=0) < min(len(shape) for shape in shapes):
                raise
        return tuple(array(item, *shapes, what=f"for each body {what}") for item in value)

    return Annotated[tuple, BeforeValidator(check)]


def _depth(value):
    """How many lists a number is in."""
    return 1 + _depth(value[0]) if isinstance(value, (list, tuple)) and value else 0


Places = _for_each((3,), what="3 numbers [x, y, z]")
Blocks = _for_each((6, 6), (6,), what="a 6x6 matrix, 6 rows of 6 numbers, or its diagonal, 6 numbers")


class HydrodynamicsOptions(Part):
    """Coefficients over frequency from a file.

    file : WAMIT's NAME.1, with NAME.3 beside it (also NAME.3.gz); a dataset of capytaine (.nc) or a file of BEMIO (.h5), which want
        pip install h5py; NEMOH's RadiationCoefficients.tec, with ExcitationForce.tec beside it. At 4 frequencies or more; an
        element or a motion is given at all of them, or, as zero, at none. WAMIT's files begin with the period in s. Its lines of period 0
        (infinite frequency) in NAME.1 are read and not needed unless radiation = false: added mass there follows from the rest. Those of period -1
        (frequency 0) are passed over. Of NAME.3 the real and imaginary parts count: force is Re((re + i im) amplitude exp(+i omega t)) for
        an elevation amplitude cos(omega t) at the origin of the coefficients, as WAMIT has it: a positive phase leads. Headings are the way
        waves travel.
    bodies : numbers from 1 of the bodies of the file that the ends are of, in their order; left out, all. Others are as if held still.
    scale : m, the length that WAMIT's numbers are non-dimensional by (ULEN).
    froude : how many times as large the bodies are as those of the file, by Froude's law, as of a model in a tank: lengths grow with it,
        times with its root, masses and forces with its third power, in water of the density that the scene has.
    spikes : whether frequencies at which both added mass and damping jump, as at irregular frequencies of a mesh without a lid, are kept,
        and told, or "cut" out: neighbours are splined over then.
    reference : (3,) m in the axes of the end, the point of the body that the coefficients are about; left out, the end's origin. Of
        several bodies one for each.
    radiation : how the memory of waves made is fitted, or false: none, added mass at infinite frequency alone.
    excitation : whether the sea's waves act; or "input": force (N) and moment (N m) about the point of reference, inertial axes, are inputs
        of the FMU in their place, so that a sea from elsewhere drives the body.
    position : where waves meet a body. "mean": where it starts; loads are kept at knots in time. "now": where its point of reference is,
        so that phases lag as it drifts; that is the plain sum of components, anew at each evaluation (200 of them cost some us).
    axes : that coefficients, `damping` and `quadratic` are in. "first", the inertial ones, for bodies that keep their heading. "heading",
        those turned about z by the yaw of the end's axes, for a ship that turns (upside down it has none, and a run through exactly that
        ends): the memory turns with it, and waves meet it at their
        direction less its yaw, for which the file's headings go all the way round; that is the plain sum of components at each
        evaluation. "body", the end's, for a body deep in water at any angle, which no waves of the sea act on. Of one body.
    damping : (6, 6) N s/m, N s, N m s, or its diagonal, beside waves made: force and moment about the point of reference are -damping
        (velocity, angular velocity), in `axes`. Of several bodies one for each.
    quadratic : likewise, of each component of velocity and angular velocity times its size.
    """

    file: DataName = Field(description='as in file = "barge.1"')
    bodies: Annotated[tuple[int, ...], BeforeValidator(_numbers)] | None = None
    scale: Positive = 1.0
    froude: Positive = 1.0
    spikes: OneOf("keep", "cut") = "keep"
    reference: Places | None = None
    radiation: number_or(Boolean, RadiationOptions) = True
    excitation: Excitation = True
    position: OneOf("mean", "now") = "mean"
    axes: OneOf("first", "heading", "body") = "first"
    damping: Blocks | None = None
    quadratic: Blocks | None = None

    @model_validator(mode="after")
    def _check_together(self):
        if "position" in self.model_fields_set and self.excitation is not True:
            raise ValueError(
                f"position is about waves of the sea, and excitation is {show(self.excitation)}; leave it out"
            )

        if self.froude != 1.0 and isinstance(self.radiation, RadiationOptions) and self.radiation.file:
            raise ValueError(
                "froude scales coefficients; radiation.file is a ready model of one size: leave one of them out"
            )

        for key in ("damping", "quadratic"):
            for k, matrix in enumerate(self.matrices(key), 1):
                if matrix.diagonal().min() < 0.0:
                    j = int(matrix.diagonal().argmin()) + 1
                    raise ValueError(
                        f"{key} gives energy: [{j}][{j}] is {show(float(matrix.diagonal().min()))}"
                        + (f" of body {k}" if k > 1 else "")
                        + "; it takes energy where its diagonal is not negative"
                    )
        return self

    def matrices(self, key):
        """[(6, 6)] of a key: of the one body, or of each; [] where it is left out."""
        value = getattr(self, key)
        if value is None:
            return []

        several = _depth(value) == 3 or (_depth(value) == 2 and len(value) != 6)
        found = [np.array(item) for item in (value if several else (value,))]
        return [np.diag(item) if item.ndim == 1 else item for item in found]

    def places(self):
        """[(3,)] m: of the point of reference of the one body, or of each; [] where it is left out."""
        if self.reference is None:
            return []
        return [
            np.array(item) for item in (self.reference if _depth(self.reference) == 2 else [self.reference])
        ]


class Hydrodynamics(Part):
    """hydrodynamics = { file, bodies, scale, radiation, excitation, ... }, on : the end about whose origin the coefficients are.

    Cummins' equation: added mass at infinite frequency (part of the body's inertia), memory of the waves that the body makes, and what
    those of the sea do to it. Axes are those of the inertial frame, whatever way the body turns (linear theory), or `axes`. Buoyancy
    is for `hydrostatics` or `linear` beside it.

    Of a file of several bodies `on` is a list, an end for each. They feel the waves that the others make, and move their water; loads of
    the sea are those at the places that the file has them at, whose origin is that of the inertial frame. Such scenes are of
    `formulation` "embedding".

    output : force (N) and moment (N m) of radiation, without added mass, of excitation, and of `damping` and `quadratic`, about the end's
        origin or `reference`, inertial axes; their powers on the body, W. Of several bodies each has its own: water.ship.radiation_force.
    """

    kind: ClassVar[str] = "hydrodynamics"
    input: ClassVar[tuple] = ()

    hydrodynamics: HydrodynamicsOptions
    on: Ends = Field(description='the end about which the coefficients are, as in on = "body.waterline"')
    output: SomeOf(*HYDRODYNAMICS_OUTPUTS) = ()

    @model_validator(mode="after")
    def _check_numbers(self):
        spec, ends = self.hydrodynamics, len(self.between)
        told = {key: len(spec.matrices(key)) for key in ("damping", "quadratic")} | {
            "reference": len(spec.places())
        }
        for key, count in told.items():
            if count not in (0, ends):
                ends_told = "one end" if ends == 1 else f"{ends} ends"
                raise ValueError(
                    f"{key} is of {count} bod{'y' if count == 1 else 'ies'}, `on` names {ends_told}; one for each"
                )
        return self

    @property
    def between(self):
        """The ends."""
        return (self.on,) if isinstance(self.on, str) else self.on


class MemberOptions(Part):
    """diameter : m.
    drag : coefficient across the axis, by diameter and length.
    axial_drag : coefficient along it, by the area of the disc, for each end that is under water.
    added_mass : coefficient across the axis, by the mass of the water that it displaces where it starts. Left out, no inertia of the water and no
        pressure of waves acts: other elements of the body know of both.
    axial_added_mass : coefficient along it, for each end that starts under water, by half a ball of water on its disc.
    waves : whether those of the sea move its water.
    position : where it feels them. "mean": where it starts; how the water moves is kept at knots in time. "now": where it is, so that
        phases lag as it drifts, and it feels those of the depth that it is at; that is the plain sum of components, anew for each point at
        each evaluation (8 us a point of 200 of them).
    sections : of equal lengths, with two points each on what of them is wet.
    """

    diameter: Positive
    drag: NotNegative = 1.0
    axial_drag: NotNegative = 0.0
    added_mass: NotNegative | None = None
    axial_added_mass: NotNegative = 0.0
    waves: Boolean = True
    position: OneOf("mean", "now") = "mean"
    sections: whole(1, 100) = 4

    @model_validator(mode="after")
    def _check_added_mass(self):
        if self.axial_added_mass and self.added_mass is None:
            raise ValueError("axial_added_mass needs added_mass beside it, as in added_mass = 1.0")
        if "position" in self.model_fields_set and not self.waves:
            raise ValueError("position is about waves of the sea, and waves is false; leave it out")
        return self


class Member(Part):
    """member = { diameter, drag, axial_drag, added_mass, ... }, between : two ends on one body, round it is between them.

    Morison's formula for what of it is under water: drag in the velocity of the water, of current and waves, less its own; with `added_mass`
    also the inertia of that water, the part of the member's own acceleration as added mass, and the pressure of waves on its ends. The
    waves are those at the places where it starts, or where it is (`position`). Buoyancy is for `hydrostatics` or `linear` beside it.

    output : force of the water (N, inertial frame), its power on the body (W).
    """

    kind: ClassVar[str] = "member"
    input: ClassVar[tuple] = ()

    member: MemberOptions
    between: Between = Field(description='its two ends, as in between = ["hull.keel", "hull.deck"]')
    output: SomeOf(*MEMBER_OUTPUTS) = ()


def csv_columns(file, count):
    """(n, count) numbers of a CSV file with a line of names. Raises ValueError that names file and line."""
    try:
        _, lines = csv_table(file.path)
    except OSError as error:
        raise ValueError(f"{file.path}: {error.strerror or error}") from None

    rows = []
    for at, cells in lines:
        line = ",".join(cells)
        try:
            row = [float(cell) for cell in cells]
        except ValueError:
            raise ValueError(f"{file.path}: line {at} is no row of numbers: {line[:60]!r}") from None
        if len(row) != count or not np.isfinite(row).all():
            raise ValueError(f"{file.path}: line {at} needs {count} finite numbers, found {line[:60]!r}")
        rows.append(row)

    if len(rows) < 1 + (count == 2):
        raise ValueError(f"{file.path}: holds too few rows")
    return np.array(rows)
