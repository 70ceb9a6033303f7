"""Trim: values of inputs, start values and parameters for which the scene does what is asked for
(docs/theory.md 19.7).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..compiler.variables import dotted, hint, meant
from ..kernels import entry
from ..kernels.status import OK
from ..run.instance import explain
from ..scene import SceneData, variable_name
from ..scene.errors import listed
from .equilibrium import settle
from .manifold import Manifold, NoState
from .places import mechanism_of
from .rest import allowed, observed, started_moving

# steps of Newton's method, halvings of one, and when it is done: residuals beside 1 (SI), or what they are
# sums of
STEPS = 50
HALVINGS = 12
DONE = 1e-11

# residuals (SI) from which on conditions are not kept
KEPT = 1e-7

# step of differences, as part of an unknown's size
NEAR = 1e-5

# singular values below that part of the largest: unknowns that conditions do not tell
UNTOLD = 1e-9


@dataclass(frozen=True)
class Trim:
    """What was found.

    values : unknowns by variable name, SI. conditions : {name: (value asked for, value found)}. inputs,
        parameters : those to run the scene with, as `simulate` takes them. scene : with the start that was
            found.
    unsteady : {rate: its rate of change} of joint speeds that change there. error : the largest residual, SI.
    notices : what a user should be told.
    """

    values: dict[str, float]
    conditions: dict[str, tuple[float, float]]
    inputs: dict[str, float]
    parameters: dict[str, float]
    scene: SceneData
    unsteady: dict[str, float]
    units: dict[str, str | None]
    error: float
    iterations: int
    notices: list[str]
    manifold: Manifold = field(repr=False)

    def linearise(self, inputs=None, outputs=None):
        """The linear model about it; see `mbdfmi.analysis.linear.Linear`."""
        from .linear import about

        return about(self.manifold, inputs, outputs)


def trim(
    scene: SceneData,
    find: Sequence[str] | Mapping[str, float | None] | None = None,
    keep: Mapping[str, float] | None = None,
    *,
    steady: Sequence[str] | bool = (),
    rest: bool = False,
    hold: Mapping[str, float] | None = None,
    parameters: Mapping[str, float] | None = None,
    time: float = 0.0,
    progress: Callable[[str], None] | None = None,
) -> Trim:
    """Values for which conditions hold.

    find : names of inputs, of parameters, or of joints' coordinates and rates at the start ("lean.angle" is
        lean.angle_start), with a first guess or None (their present value). By default all is as the scene's
        `solver.trim` has it.
    keep : {name: value} of outputs, SI; of joints and bodies also of those that the scene does not ask for,
        as "shaft.acceleration".
    steady : joints whose speeds shall not change, or True for all.
    rest : all this holds in the static equilibrium that the scene comes to from its start, instead of at the
        start.
    hold, parameters : other values of inputs and parameters. time : s.

    Newton's method; with fewer conditions than unknowns the nearest solution. Raises ValueError where none is
    found, and says which condition is off; KeyError for unknown names.
    """
    asked = scene.solver.trim

    if find is None and not keep and not steady and not rest and asked:
        find, keep, steady, rest = asked.find, asked.keep, asked.steady, asked.rest

    search = _Search(scene, find, keep or {}, steady, rest, hold, parameters, time)
    iterations = search.run(progress)
    return search.told(iterations)


class _Search:
    def __init__(self, scene, find, keep, steady, rest, hold, parameters, time):
        if not find:
            raise ValueError("trim: nothing to find; name inputs, parameters or start values")

        self.scene, self.rest, self.time = scene, rest, time
        self.keep = {variable_name(name): float(value) for name, value in keep.items()}
        seen = _seen(observed(scene), self.keep)
        self.mechanism = mechanism_of(seen, hold, parameters, time)
        self.given = dict(parameters or {})
        self.model = self.mechanism.model
        self.guess = find if isinstance(find, Mapping) else dict.fromkeys(find)
        self._find_unknowns()
        self._find_conditions()
        names = (
            list(scene.joint)
            if steady is True
            else [steady]
            if isinstance(steady, str)
            else list(steady or ())
        )

        for name in names:
            if name not in scene.joint:
                raise KeyError(f"steady: no joint {name!r}; {hint(name, list(scene.joint))}")

        self.steady = names

        if rest and names:
            raise ValueError("rest: nothing moves there; steady is for what moves")
        if not self.keep and not names:
            raise ValueError("trim: no condition; keep an output at a value, or ask for a steady motion")

    def _find_unknowns(self):
        by_name = {v.name: v for v in self.model.variables if v.causality in ("input", "parameter")}
        self.unknowns = []

        for name in self.guess:
            plain = variable_name(name)
            base, bracket, index = plain.partition("[")
            found = next((key for key in (plain, f"{base}_start{bracket}{index}") if key in by_name), None)

            if found is None:
                several = meant(plain, by_name) or meant(f"{plain}_start", by_name)
                more = f"; name one of {listed(several)}" if several else f"; {hint(plain, by_name)}"
                raise KeyError(f"find: no input, parameter or start value {name!r}{more}")

            self.unknowns.append((name, by_name[found]))

        instance = self.mechanism.instance
        self.x = np.array([self._value(instance, v) for _, v in self.unknowns])

        for k, (name, _) in enumerate(self.unknowns):
            first = self.guess[name]
            self.x[k] = self.x[k] if first is None else float(first)

    @staticmethod
    def _value(instance, v):
        return float((instance.u if v.causality == "input" else instance.reals)[v.index])

    def _find_conditions(self):
        outputs = {v.name: v.index for v in self.model.of_causality("output")}

        for name in self.keep:
            if name not in outputs:
                several = meant(name, outputs)
                more = f"it is an array, name one of {listed(several)}" if several else hint(name, outputs)
                raise KeyError(f"keep: no output {name!r}; {more}")

        self.y_at = [outputs[name] for name in self.keep]
        self.y_wanted = np.array(list(self.keep.values()))

    def _put(self, x):
        """The state by values of the unknowns, in the mechanism's instance."""
        instance = self.mechanism.instance
        self.mechanism.thaw()

        for (_, v), value in zip(self.unknowns, x):
            (instance.u if v.causality == "input" else instance.reals)[v.index] = value

        instance.prepare()
        status = entry.initialise(instance.m, instance.d, self.time)

        if status != OK:
            raise NoState(explain(self.model, status))

        if self.rest:
            settle(self.mechanism)

    def residuals(self, x):
        """Conditions less what is asked for."""
        self._put(x)
        instance = self.mechanism.instance
        found = [instance.outputs()[self.y_at] - self.y_wanted]

        if self.steady:
            manifold = Manifold(self.mechanism)
            rates = manifold.unsteady()
            own = [
                k
                for k, named in enumerate(manifold.named)
                if named.joint in self.steady and k in manifold.speeds
            ]
            found.append(rates[own])

        return np.concatenate(found)

    def _try(self, x):
        try:
            return self.residuals(x)
        except (NoState, ArithmeticError):
            return None

    def run(self, progress):
        """Steps of Newton's method. Raises ValueError."""
        now = self.residuals(self.x)

        for iteration in range(STEPS):
            if progress:
                progress(f"step {iteration + 1}, off by {np.abs(now).max(initial=0.0):.3g}")

            J = self._derivatives(len(now))
            self.J = J
            size = np.linalg.norm(J, axis=0)
            size[size == 0.0] = 1.0
            step = -np.linalg.lstsq(J / size, now, rcond=UNTOLD)[0] / size

            for _ in range(HALVINGS):
                there = self._try(self.x + step)

                if there is not None and np.linalg.norm(there) < np.linalg.norm(now):
                    break

                step = 0.5 * step
            else:
                break

            self.x = self.x + step
            small = np.all(np.abs(step) <= 1e-14 * np.maximum(1.0, np.abs(self.x)))
            now = there

            if np.abs(now).max(initial=0.0) <= DONE or small:
                break

        self.now = self.residuals(self.x)
        self.error = float(np.abs(self.now).max(initial=0.0))

        if not self.error <= KEPT * max(1.0, np.abs(self.y_wanted).max(initial=0.0)):
            raise ValueError(f"no trim was found: {self._worst()}")

        return iteration + 1

    def _derivatives(self, n):
        J = np.empty((n, len(self.x)))

        for k in range(len(self.x)):
            h = NEAR * max(1.0, abs(self.x[k]))
            ahead, behind = self.x.copy(), self.x.copy()
            ahead[k] += h
            behind[k] -= h
            J[:, k] = (self.residuals(ahead) - self.residuals(behind)) / (2.0 * h)

        return J

    def _worst(self):
        """The condition that is furthest off, in words."""
        k = int(np.abs(self.now).argmax())
        names = list(self.keep)

        if k < len(names):
            name = names[k]
            text = f"{name} comes to {self.y_wanted[k] + self.now[k]:.6g}, not {self.y_wanted[k]:.6g}"
        else:
            text = f"the speeds of {listed(self.steady)} go on changing, by {self.now[k]:.3g} a second"

        still = [
            name for (name, _), column in zip(self.unknowns, self.J.T) if not np.abs(column).max(initial=0.0)
        ]
        return text + (
            f"; {listed(still)} {'does' if len(still) == 1 else 'do'} nothing for it" if still else ""
        )

    def told(self, iterations) -> Trim:
        """What was found."""
        model, instance = self.model, self.mechanism.instance
        values = dict(zip((v.name for v in model.of_causality("output")), instance.outputs().tolist()))
        manifold = Manifold(self.mechanism)
        unsteady = manifold.unsteady()
        moving = {
            named.rate: float(rate)
            for named, rate, unit in zip(manifold.named, unsteady, manifold.unit)
            if abs(rate) / unit > 1e-6
        }
        found = {v.name: float(value) for (_, v), value in zip(self.unknowns, self.x)}
        singular = np.linalg.svd(self.J, compute_uv=False)
        rank = int(np.sum(singular > UNTOLD * max(singular.max(initial=0.0), 1e-300)))
        notices = list(self.mechanism.model.notices)

        if rank < len(self.x):
            notices.append(
                f"the conditions tell {rank} of {len(self.x)} unknowns: this is the solution "
                "nearest to the first guess"
            )

        inputs = {v.name: found[v.name] for _, v in self.unknowns if v.causality == "input"}
        changed = {
            v.name: found[v.name]
            for _, v in self.unknowns
            if v.causality == "parameter" and not v.name.split("[")[0].endswith("_start")
        }
        return Trim(
            values=found,
            conditions={name: (wanted, values[name]) for name, wanted in self.keep.items()},
            inputs=inputs,
            parameters=self.given | changed,
            scene=started_moving(self.scene, values, manifold),
            unsteady=moving,
            units={v.name: v.unit for v in model.variables},
            error=self.error,
            iterations=iterations,
            notices=notices,
            manifold=manifold,
        )


def _seen(scene, names):
    """The scene with outputs of those names too, as far as joints, bodies and markers have them."""
    joints, bodies = dict(scene.joint), dict(scene.body)
    known = {dotted(name): name for name in (*joints, *bodies)}

    for name in names:
        owner, _, quantity = name.partition(".")
        owner, quantity = known.get(owner), quantity.split("[")[0]

        if owner in joints and quantity not in joints[owner].output and allowed(joints[owner], quantity):
            output = [*joints[owner].output, quantity]
            joints[owner] = joints[owner].model_copy(update={"output": output})
        elif owner in bodies:
            bodies[owner] = _with_output(bodies[owner], quantity)

    return scene.model_copy(update={"joint": joints, "body": bodies})


def _with_output(body, quantity):
    """A body that tells a quantity, or that of one of its markers."""
    marker, _, of_marker = quantity.rpartition(".")

    if not marker:
        new = quantity not in body.output and allowed(body, quantity)
        return body.model_copy(update={"output": [*body.output, quantity]}) if new else body

    part = next((part for key, part in body.marker.items() if dotted(key) == marker), None)

    if part is None or of_marker in part.output or not allowed(part, of_marker):
        return body

    key = next(key for key in body.marker if dotted(key) == marker)
    changed = part.model_copy(update={"output": [*part.output, of_marker]})
    return body.model_copy(update={"marker": body.marker | {key: changed}})
