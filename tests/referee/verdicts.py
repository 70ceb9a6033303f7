"""One scene before the referee: all its ways, and every verdict on them."""

import time as clock
import traceback
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from mbdfmi import Scene
from mbdfmi.run.instance import Instance, SimulationError
from mbdfmi.scene import SceneError

from . import commands, compare, dependence, draws, exactness, laws, route, starts
from . import plan as plans
from .findings import Count, Finding
from .independent import unknown
from .ways import TIGHT, Libraries, Way, model_of, run

LIGHT = 1e-5  # parts of the heaviest

SPENT = "max_evaluations"

# up to so many times what is allowed a way may be off, if a tolerance smaller by SMALLER or a quarter of the step
# leaves less than the part LESS of it
UNSURE = 50.0
SMALLER = 1e-2
LESS = 0.1


@dataclass
class Verdict:
    """What the referee says of a scene.

    told : all that a user is told of the scene and of the reference. first : what the reference starts with.
    """

    seed: int
    findings: list[Finding] = field(default_factory=list)
    count: Count = field(default_factory=Count)
    refused: str | None = None
    stopped: str | None = None
    told: list[str] = field(default_factory=list)
    first: dict[str, float] = field(default_factory=dict)
    seconds: float = 0.0


def judge(data, seed, interpreter=None, fmu=True, n=3, until=None, signals=None):
    """The verdict on a scene (a dict).

    interpreter : `Interpreter`, or None to go without. until : s, else drawn. signals : inputs other than those drawn, name ->
    coefficients of the powers of time; the derivatives are not told.
    """
    begun = clock.perf_counter()
    verdict = Verdict(seed)

    with TemporaryDirectory() as folder, Libraries() as libraries:
        _judge(data, seed, verdict, interpreter, fmu, n, until, signals or {}, Path(folder), libraries)

    verdict.seconds = clock.perf_counter() - begun
    return verdict


def _judge(data, seed, verdict, interpreter, fmu, n, until, signals, folder, libraries):
    try:
        scene = Scene.model_validate(data)
        model = model_of(data, Way())
    except SceneError as error:
        verdict.refused = str(error)
        verdict.told.append(str(error))
        verdict.findings += (
            [] if str(error).strip() else [Finding("not told", "reading", text="refused without a word")]
        )
        return

    plan = plans.draw(seed, model, until).under(signals)
    ways = draws.draw(seed, plan, n, fmu, interpreter is not None, len(scene.body))
    runs = [run(data, plan, way) for way in ways.near]
    reference, kicked = _reference(data, plan, ways)
    findings, count = verdict.findings, verdict.count
    ends = [text for text in (reference.refused, reference.stopped) if text]
    verdict.told += scene.notices + reference.notices + ends

    for other in [*runs, reference]:
        findings += laws.always(other, data)

    if reference.refused is not None:
        verdict.refused = reference.refused
        findings += [
            Finding(
                "refused", str(other.way), text=f"runs, but the reference is refused: {reference.refused}"
            )
            for other in runs
            if other.refused is None and other.way.host == "process"
        ]
        return

    verdict.stopped = reference.stopped
    verdict.first = dict(zip(reference.names, reference.values[0]))
    units = {v.name: v.unit for v in model.of_causality("output")}
    exact = exactness.of(data, scene, model, plan, reference)
    of = compare.Reference(reference, kicked, units, exact)
    _near(data, plan, ways, runs, of, verdict)
    _bits(data, plan, ways, runs, verdict, libraries)

    for way, k in ways.rounding if interpreter else ():
        other = interpreter.run(data, plan, way)
        findings += laws.always(other, data)
        findings += compare.near(of, other, count, twin=runs[k])

    if ways.integrals and reference.whole:
        _balances(data, scene, plan, ways, of, verdict)

    _second_route(data, plan, reference, exact, verdict)

    if has_light_parts(scene):
        for other in [r for r in runs if r.way.formulation == "augmented" and not r.way.plain][:1]:
            _second_route(data, plan, other, exact, verdict)

    findings += commands.straight(data, plan, reference)

    for other in runs:
        findings += commands.met(plan, other)

    findings += starts.kept(data, reference)
    findings += starts.written(data)
    findings += dependence.told(model)
    _dependence(model, plan, findings)
    findings += starts.checked(scene, folder / "scene.toml")
    count.add("stopped early", reference.stopped is not None)


def _reference(data, plan, ways):
    """(reference, kicked runs): with an implicit method where explicit steps are too many."""
    way = ways.reference
    found = run(data, plan, way)

    if found.stopped and SPENT in found.stopped:
        other = run(data, plan, replace(way, integrator="radau", tolerance=1e-10))
        found = other if len(other.values) > len(found.values) else found

    return found, [run(data, plan, replace(found.way, kick=kick.kick)) for kick in ways.kicked]


def _near(data, plan, ways, runs, of, verdict):
    # what hangs on a drive whose speed jumps goes on as each formulation and step has it
    until = min([of.exact.until, *(t for t in laws.jumps(data) if t > 0.0)])

    for k, other in enumerate(runs):
        # a speed that jumps gives no impulse: how the motion goes on is a matter of the formulation
        if other.way.formulation == "augmented" and plans.speeds_unknown(plan):
            verdict.count.add("speeds that jump where they become known")
            continue

        if _starts_elsewhere(data, other, of):
            verdict.count.add("started elsewhere, and told")
            continue

        half = [run(data, plan, way) for way in ways.halved[k]] if k in ways.halved else None
        found = compare.near(of, other, verdict.count, half, until=until, kinked=kinked(data))
        verdict.findings += [f for f in found if not _converges(data, plan, other.way, f, verdict.count)]

        # who stops where the reference goes on
        if other.way.step or other.stopped is None or not of.run.whole or SPENT in other.stopped:
            verdict.count.add("stopped where others go on", other.stopped is not None and of.run.whole)
        else:
            text = f"stops where the reference goes on: {other.stopped}"
            verdict.findings.append(Finding("stopped", str(other.way), time=other.times[-1], text=text))


def _converges(data, plan, way, finding, count):
    """Whether what is not much too far off is much less so with a smaller tolerance, or a smaller step.

    How far an error may grow is measured at communication points alone: it may be more where a motion passes
    something near to singular between two of them; and fixed steps may be too long to tell their error.
    """
    if finding.beyond > UNSURE:
        return False

    closer = {"step": way.step / 4} if way.step else {"tolerance": max(TIGHT, SMALLER * way.tolerance)}
    other = run(data, plan, replace(way, **closer))
    same = np.array(other.times) == finding.time

    if finding.variable not in other.names or not same.any():
        return False

    values = np.array(other.values)[same, other.names.index(finding.variable)]
    less = bool(np.any(np.abs(values - finding.wanted) < LESS * abs(finding.found - finding.wanted)))
    count.add("off, and less so with a smaller tolerance", less)
    return less


def _bits(data, plan, ways, runs, verdict, libraries):
    for way, k in ways.bits:
        other = run(data, plan, way, libraries)
        verdict.findings += laws.always(other, data)
        verdict.findings += compare.same(other, runs[k], f"as [{runs[k].way}] to the bit")

        if way.host == "fmu" and way.memory is None and runs[k].whole:
            verdict.findings += starts.alike(runs[k], other)


def _balances(data, scene, plan, ways, of, verdict):
    way = replace(ways.integrals, integrator=of.run.way.integrator, tolerance=of.run.way.tolerance)
    found = _unbalanced(data, scene, plan, way, of, verdict.count)

    # short events need many points: twice as many times more
    for panels in (laws.PANELS * laws.FINER, laws.PANELS * laws.FINER**2):
        if found:
            way = replace(way, pattern=("equal", panels))
            finer = _unbalanced(data, scene, plan, way, of, verdict.count)
            found = [f for f in found if any(laws.persists(f, g) for g in finer)]

    verdict.findings += found


def _unbalanced(data, scene, plan, way, of, count):
    """What does not balance over the intervals of a run made for it."""
    found = run(data, plan, way)

    if not found.whole:
        count.add("no balance")
        return []

    integrals = laws.Integrals(found, way.pattern[1], laws.jumps(data), laws.edges(scene))
    unbalanced = laws.courses(integrals, count)

    if not laws.bed_moves(data):
        unbalanced += laws.energy(integrals, of, count)

    if laws.bears_all(data):
        unbalanced += laws.momentum(integrals, of, count, *laws.mass_and_gravity(scene, plan))

    return unbalanced


def has_light_parts(scene):
    """Whether some part weighs next to nothing beside another: absolute coordinates then lose digits."""
    masses = [body.mass_properties()[0] for body in scene.body.values()]
    return min((mass for mass in masses if mass > 0.0), default=1.0) < LIGHT * max(masses)


def _second_route(data, plan, reference, exact, verdict):
    if unknown(data):
        verdict.count.add("with joints that the second route does not know")
        return

    try:
        verdict.findings += route.agrees(data, plan, reference, exact, verdict.count)
    except Exception:
        verdict.findings.append(
            Finding("second route", str(reference.way), text=traceback.format_exc().strip())
        )


def _dependence(model, plan, findings):
    try:
        instance = Instance(model, inputs=dict(enumerate(plan.inputs(0.0, 0)[0])))
        instance.step(0.5 * plan.points[1])
        findings += dependence.observed(model, instance, "process")
    except SimulationError:
        pass


def _starts_elsewhere(data, run, of):
    """Whether a run of another formulation starts elsewhere than the reference, where that is told or,
    in absolute coordinates, where inputs command motions: their starts are found before."""
    if run.way.formulation == of.run.way.formulation:
        return False

    if starts.moved(run) != starts.moved(of.run):
        return True

    late = run.way.formulation == "augmented" and _commanded(data)
    return late and compare.near(of, run, Count(), until=1e-12) != []


def _commanded(data):
    """Whether inputs command motions."""
    motions = [*laws.drivers(data), data.get("ground", {}).get("motion", {})]
    return any("input" in motion for motion in motions)


def kinked(data):
    """Whether forces or their rates may jump, or change within a step: stops, friction, tables."""
    parts = [*data.get("joint", {}).values(), *data.get("force", {}).values()]
    return any("stop" in part or "friction" in part or "table" in str(part) for part in parts)
