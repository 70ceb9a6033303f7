"""The righting arm of a hull over its heel, sinkage and trim left free (docs/theory.md 19.8)."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import scipy  # which imports its parts when they are asked for

from ..compiler.variables import dotted
from ..files import check_ending, save_figure
from ..run.results import Results
from ..scene import SceneData
from ..scene.errors import did_you_mean, listed
from .equilibrium import NoEquilibrium, descend
from .manifold import Manifold, NoState
from .places import mechanism_of

# deg, of the curve without being told
STEP, LAST = 2.0, 90.0

# of the joints and bodies that take the place of the hull's own joint
PREFIX = "righting"

# rad, of the slope at no heel
SMALL = 1e-4


@dataclass(frozen=True)
class Righting:
    """A righting-arm curve.

    heel : (n,) deg, about the hull's own axis. arm : (n,) m, positive where it rights; NaN where nothing
        balances.
    trim : (n,) deg, about the level axis across. draught : (n,) m, depth of the lowest point. displaced :
        (n,) m3.
    metacentric : m, GM: the slope of the arm at no heel, by rad. notices : what a user should be told.
    """

    hull: str
    axis: str
    heel: np.ndarray
    arm: np.ndarray
    trim: np.ndarray
    draught: np.ndarray
    displaced: np.ndarray
    metacentric: float
    title: str
    notices: list[str] = field(default_factory=list)

    def _curve(self):
        known = np.isfinite(self.arm)
        return scipy.interpolate.CubicSpline(self.heel[known], self.arm[known]) if known.sum() > 3 else None

    def rests(self) -> list[tuple[float, bool]]:
        """[(heel in deg, stable)] where the arm is 0, between the angles looked at by a spline."""
        curve = self._curve()

        if curve is None:
            return []

        roots = [float(root) for root in np.unique(np.round(curve.roots(extrapolate=False), 9))]
        return [(root, bool(curve(root, 1) > 0.0)) for root in roots]

    def largest(self) -> tuple[float, float]:
        """(heel in deg, arm in m) of the largest arm."""
        curve = self._curve()

        if curve is None:
            k = int(np.nanargmax(self.arm))
            return float(self.heel[k]), float(self.arm[k])

        known = self.heel[np.isfinite(self.arm)]
        places = [*curve.derivative().roots(extrapolate=False), known[0], known[-1]]
        best = max(places, key=curve)
        return float(best), float(curve(best))

    def area(self, first: float, last: float) -> float:
        """m rad, under the arm between two heels (deg)."""
        curve = self._curve()

        if curve is None:
            raise ValueError("there are too few points of the curve")

        return float(np.radians(1.0) * curve.integrate(first, last))

    def results(self) -> Results:
        """The curve as a table."""
        columns = {
            "heel": self.heel,
            "arm": self.arm,
            "trim": self.trim,
            "draught": self.draught,
            "displaced": self.displaced,
        }
        units: dict[str, str | None] = {
            "heel": "deg",
            "arm": "m",
            "trim": "deg",
            "draught": "m",
            "displaced": "m3",
        }
        return Results(columns, units, self.title, self.notices)

    def plot(self, path) -> Path:
        """Draw the curve (png, svg, pdf). Returns the path."""
        from matplotlib.figure import Figure

        path = Path(path)
        check_ending(path, "a picture is to be drawn", ".png", ".svg", ".pdf")
        figure = Figure(figsize=(9, 6.4), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=[3, 1])
        curve = self._curve()

        if curve is not None:
            known = self.heel[np.isfinite(self.arm)]
            fine = np.linspace(known[0], known[-1], 600)
            above.plot(fine, curve(fine), linewidth=1.8, color="tab:blue")
            above.fill_between(fine, 0.0, curve(fine), alpha=0.10, color="tab:blue")
            heel, arm = self.largest()
            above.plot(heel, arm, "^", color="tab:blue")
            above.annotate(
                f"{arm:.3g} m at {heel:.3g}°", (heel, arm), (0, 8), textcoords="offset points", ha="center"
            )

        above.plot(self.heel, self.arm, ".", markersize=4, color="tab:blue")
        self._draw_slope(above)

        for heel, stable in self.rests():
            above.plot(heel, 0.0, "o", color="black", fillstyle="full" if stable else "none")
            words = "rests" if stable else "capsizes"
            above.annotate(f"{words} {heel:.3g}°", (heel, 0.0), (6, 8), textcoords="offset points")

        above.margins(y=0.12)
        above.axhline(0.0, color="black", linewidth=0.8)
        above.set_ylabel("righting arm GZ [m]")
        above.grid(alpha=0.3)
        below.plot(self.heel, self.trim, color="tab:green", label="trim [deg]")
        below.plot(self.heel, self.draught, color="tab:brown", label="draught [m]")
        below.set_xlabel(f"heel of {self.hull} about its {self.axis} axis [deg]")
        below.legend(loc="best", fontsize="small")
        below.grid(alpha=0.3)
        figure.suptitle(self.title)

        save_figure(figure, path, dpi=150)

        return path

    def _draw_slope(self, panel):
        """The slope at no heel, GM at one radian."""
        if not (np.isfinite(self.metacentric) and self.heel[0] <= 0.0 < self.heel[-1]):
            return

        at = self.arm[np.abs(self.heel).argmin()]
        top = 0.8 * np.nanmax(np.abs(self.arm)) + abs(at)
        reach = min(np.degrees(1.0), self.heel[-1], np.degrees(top / max(abs(self.metacentric), 1e-30)))
        panel.plot(
            [0.0, reach], [at, at + np.radians(reach) * self.metacentric], "--", color="0.5", linewidth=1.0
        )
        panel.annotate(
            f"GM {self.metacentric:.4g} m",
            (reach, at + np.radians(reach) * self.metacentric),
            (-6, 0),
            textcoords="offset points",
            color="0.4",
            ha="right",
        )


def righting(
    scene: SceneData,
    hull: str | None = None,
    axis: str | float = "x",
    *,
    heel=None,
    hold: Mapping[str, float] | None = None,
    parameters: Mapping[str, float] | None = None,
    time: float = 0.0,
    progress: Callable[[str], None] | None = None,
) -> Righting:
    """The righting-arm curve of a hull that floats: at each heel it is held at, everything else is in
    equilibrium.

    hull : the body that heels; needed where several float on free joints. axis : "x", "y", or an angle (deg)
        from x to y, in the hull: that it heels about. heel : (n,) deg, ascending; by default 0 to 90 in steps
        of 2.
    hold, parameters : other values of inputs and parameters. time : s, of drives and loads.

    The arm is the moment that holds the hull, over the weight of what it displaces. What hangs or swings on
    the hull is free to do so. Raises ValueError where no hull floats on a free joint.
    """
    heel = np.arange(0.0, LAST + STEP / 2, STEP) if heel is None else np.asarray(heel, float)
    joint = _float_of(scene, hull)
    name = _hull_of(scene, joint)
    direction = {"x": 0.0, "y": 90.0}[axis] if axis in ("x", "y") else float(axis)
    held = _held(scene, joint, np.radians(direction))
    mechanism = mechanism_of(held, hold, parameters, time)
    mechanism.freeze()
    curve = _Curve(mechanism, held)
    rows, notices = [], list(mechanism.instance.notices)

    for k, angle in enumerate(heel.tolist()):
        if progress:
            progress(f"heel {angle:g} deg ({k + 1} of {len(heel)})")

        rows.append(curve.at(np.radians(angle)))

    lost = heel[[row is None for row in rows]]

    if len(lost):
        notices.append(f"nothing balances at {lost[0]:g} deg of heel{' and more' * (len(lost) > 1)}")

    columns = np.array([row or [np.nan] * 4 for row in rows]).reshape(-1, 4).T
    mechanism.d.x[:] = curve.start
    ahead, behind = curve.at(SMALL), curve.at(-SMALL)
    slope = (ahead[0] - behind[0]) / (2 * SMALL) if ahead and behind else np.nan
    shown = axis if isinstance(axis, str) else f"{direction:g} deg"
    return Righting(
        hull=name,
        axis=shown,
        heel=heel,
        arm=columns[0],
        trim=np.degrees(columns[1]),
        draught=columns[2],
        displaced=columns[3],
        metacentric=float(slope),
        title=f"{mechanism.model.title}: righting arm",
        notices=notices,
    )


class _Curve:
    """The hull held at one heel after the other."""

    def __init__(self, mechanism, scene):
        self.mechanism = mechanism
        model = mechanism.model
        m = mechanism.m
        self.heel_q, self.trim_q = (
            m.body_q[mechanism.joint_nodes[f"{PREFIX} {what}"][0]] for what in ("heel", "trim")
        )
        at = {v.name: v.index for v in model.of_causality("output")}
        self.effort = at[dotted(f"{PREFIX} heel", "driver_effort")]
        hulls = [name for name, force in scene.force.items() if force.kind == "hydrostatics"]
        self.volume = [at[dotted(name, "volume")] for name in hulls]
        self.lift = [at[dotted(name, "force") + "[3]"] for name in hulls]
        self.draught = [at[dotted(name, "draught")] for name in hulls]
        self.start = mechanism.d.x.copy()

    def at(self, heel):
        """[arm (m), trim (rad), draught (m), displaced (m3)] at a heel (rad); None where nothing balances."""
        d = self.mechanism.d
        before = d.x.copy()
        d.q[self.heel_q] = heel
        d.v[:] = 0.0

        try:
            descend(Manifold(self.mechanism))
        except (NoEquilibrium, NoState):
            d.x[:] = before
            return None

        y = self.mechanism.instance.outputs()
        trim = float(d.q[self.trim_q])
        weight = float(y[self.lift].sum())

        if not weight > 0.0:
            return None

        arm = float(y[self.effort]) / (weight * np.cos(trim))
        return [arm, trim, float(y[self.draught].max()), float(y[self.volume].sum())]


def _float_of(scene, hull):
    """The free joint that a hull floats on. Raises ValueError."""
    wet = [force.on.split(".")[0] for force in scene.force.values() if force.kind == "hydrostatics"]

    if not wet:
        raise ValueError('no hull: a righting arm needs a force with hydrostatics = { ... }, on = "body"')

    free = {}

    for name, joint in scene.joint.items():
        owners = [end.split(".")[0] for end in joint.between]

        if joint.kind == "free" and set(owners) & {"ground", "inertial"}:
            free[next(owner for owner in owners if owner not in ("ground", "inertial"))] = name

    if hull is not None:
        if hull not in free:
            raise ValueError(
                f"{hull!r} does not float on a free joint to the ground; {listed(free) or 'nothing'} "
                f"do.{did_you_mean(hull, list(free))}"
            )

        return free[hull]

    if len(free) != 1:
        raise ValueError(
            f"{listed(free)} are on free joints to the ground: name the hull (--hull)"
            if free
            else "no body is on a free joint to the ground: nothing floats"
        )

    return next(iter(free.values()))


def _hull_of(scene, joint):
    return next(
        end.split(".")[0]
        for end in scene.joint[joint].between
        if end.split(".")[0] not in ("ground", "inertial")
    )


def _held(scene, name, direction) -> SceneData:
    """The scene with a free joint taken apart: way, heading, trim about the level axis across, heel, which is
    driven.
    """
    joint = scene.joint[name]
    ends = list(joint.between)
    turned = ends[0].split(".")[0] not in ("ground", "inertial")
    ends = ends[::-1] if turned else ends
    r = np.zeros(3) if turned else joint.start.q()[:3]
    c, s = float(np.cos(direction)), float(np.sin(direction))
    parts = [f"{PREFIX} {what}" for what in ("way", "heading", "trim", "heel")]
    between = list(zip([ends[0], *parts[:3]], [*parts[:3], ends[1]]))
    kinds: list[dict] = [
        {"translation": {}, "start": {"position": r.tolist()}},
        {"revolute": {"axis": "z"}, "start": {"angle": 0.0}},
        {"revolute": {"axis": [-s, c, 0.0]}, "start": {"angle": 0.0}},
        {
            "revolute": {"axis": [c, s, 0.0]},
            "driver": {"polynomial": {"coefficients": [0.0]}},
            "output": ["driver_effort"],
        },
    ]
    made = type(scene).model_validate(
        {
            "name": "parts",
            "body": {part: {"mass": 0.0} for part in parts[:3]}
            | {"hull": {"mass": 1.0, "inertia": [1, 1, 1]}},
            "joint": {
                part: kind | {"between": [_end(end, scene) for end in pair]}
                for part, kind, pair in zip(parts, kinds, between)
            },
        }
    )
    joints = {}

    for part, pair in zip(parts, between):
        joints[part] = made.joint[part].model_copy(update={"between": tuple(pair)})

    forces = {}

    for key, force in scene.force.items():
        if force.kind == "hydrostatics":
            output = list(dict.fromkeys([*force.output, "volume", "force", "draught"]))
            forces[key] = force.model_copy(update={"output": output})

    return scene.model_copy(
        update={
            "body": {part: made.body[part] for part in parts[:3]} | scene.body,
            "joint": joints | {key: other for key, other in scene.joint.items() if key != name},
            "force": scene.force | forces,
        }
    )


def _end(end, scene):
    """An end as the small scene has it that the joints are read in."""
    owner = end.split(".")[0]
    return (
        owner
        if owner in ("ground",) or owner.startswith(PREFIX)
        else "ground"
        if owner == "inertial"
        else "hull"
    )
