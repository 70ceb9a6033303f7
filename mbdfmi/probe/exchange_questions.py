"""The questions to an FMU in model exchange: those of co-simulation that mean something, and its own."""

import math

import numpy as np

from . import questions
from .answers import ABSENT, FAULT, GOOD, TOLD
from .exchange import KINDS_OF_EVENTS, Exchanged
from .fmu import Fmu, Refused, apart
from .questions import same


def _halfway(fmu):
    """An instance in the middle of a run."""
    run = fmu.new()
    run.drive(0, fmu.steps // 2)
    return run


def _other(run):
    """A state a little off that of a run."""
    x = run.x
    return x + 1e-3 * run.nominals() * np.cos(1.0 + np.arange(len(x)))


def solved_as_in_co_simulation(fmu: Exchanged):
    """A solver outside finds what its co-simulation does, inputs held."""
    if fmu.description.coSimulation is None:
        return ABSENT, "no co-simulation"

    inside = Fmu(fmu.folder)
    fmu.held = inside.held = True
    here, there = fmu.new().drive(), inside.new().drive()
    return TOLD, f"differs by {apart(there, np.array(here)[:, : len(there[0])]):.1g}"


def starts_as_told(fmu: Exchanged):
    """States have the start values of the description."""
    x, at, wrong, asked = fmu.new().x, 0, [], 0

    for v in fmu.states:
        n = fmu.size(v)
        if v.start not in (None, "") and v.initial == "exact":
            asked += 1
            if not np.allclose(x[at : at + n], fmu.start_of(v), rtol=1e-12, atol=0):
                wrong.append(f"{v.name} starts at {x[at]:g}")
        at += n

    if wrong:
        return FAULT, "; ".join(wrong[:3])

    return (GOOD, f"{asked} read") if asked else (ABSENT, "none told" if fmu.states else "no states")


def keeps_states(fmu: Exchanged):
    """States that are set are those that are read, by themselves and as variables, and rates likewise."""
    if not fmu.n:
        return ABSENT, "no states"

    run = _halfway(fmu)
    x = _other(run)
    run.set_x(x)

    if not np.array_equal(run.x, x):
        return FAULT, f"states come back {apart([x], [run.x]):.1g} off"

    for variables, vector, what in ((fmu.states, run.x, "states"), (fmu.rates, run.rates(), "rates")):
        if not np.array_equal(run.get(variables), vector):
            return FAULT, f"variables of {what} have other values"

    return GOOD, f"{fmu.n} to the bit"


def forgets(fmu: Exchanged):
    """Rates and outputs are those of this time and state, whatever was asked before."""
    run = _halfway(fmu)
    here, there = (run.t, run.x), (run.t + 0.3 * fmu.step, _other(run))

    def ask(t, x):
        run.go(t, x)
        return [*run.rates(), *run.outputs(), *run.indicators()]

    first = [ask(*here), ask(*there)]
    return same(first, [ask(*here), ask(*there)])


def has_nominals(fmu: Exchanged):
    """Nominal values of states are above 0, and those of the description."""
    if not fmu.n:
        return ABSENT, "no states"

    found = fmu.new().nominals()
    if not (np.isfinite(found).all() and (found > 0).all()):
        return FAULT, f"{found[~(found > 0)][0]:g}" if not (found > 0).all() else "not finite"

    told = [float(v.nominal or 1.0) for v in fmu.states for _ in range(fmu.size(v))]
    return (GOOD, "as described") if np.allclose(found, told, rtol=1e-9) else (TOLD, "other ones")


def watches_events(fmu: Exchanged):
    """Event indicators are finite, and settle after each event."""
    run = fmu.new()
    if not run.n_indicators:
        return ABSENT, "no indicators"

    run.drive()
    if not np.isfinite(run.indicators()).all():
        return FAULT, "not finite"

    n, steps = run.happened["of states"], fmu.steps * fmu.parts
    return (
        FAULT if n > steps // 2 else GOOD
    ), f"{run.n_indicators}, {n} events in {steps} steps of the solver"


def tells_times_of_events(fmu: Exchanged):
    """Times of events lie ahead, and are met."""
    return _asked(_watched(fmu, "the next event", "of time"))


def completes_steps(fmu: Exchanged):
    """The end of a step leaves states as they are, unless it asks for an event."""
    if not fmu.completes:
        return ABSENT, "not needed"

    return _watched(fmu, "the end of a step", "of steps")


def tells_changes(fmu: Exchanged):
    """Events change states only where they say so."""
    return _asked(_watched(fmu, "an event changes", *KINDS_OF_EVENTS))


def _asked(answer):
    """An answer, or that nothing was seen that it could be about."""
    return (ABSENT, "no event in this run") if answer == (GOOD, "0 events") else answer


def _watched(fmu, about, *kinds):
    """What a run did wrong about something, or how many events of some kinds there were."""
    run = fmu.new()
    run.drive()
    wrong = sorted(text for text in run.wrong if text.startswith(about))
    return (FAULT, wrong[0]) if wrong else (GOOD, f"{sum(run.happened[kind] for kind in kinds)} events")


def refuses_other_sizes(fmu: Exchanged):
    """States of another number are refused."""
    if not fmu.n:
        return ABSENT, "no states"

    run = _halfway(fmu)

    try:
        run.set_x([*run.x, 0.0])
    except Refused:
        return GOOD, "refused"

    return FAULT, "accepted"


def is_honest_about_nan_in_states(fmu: Exchanged):
    """No NaN is handed out as good, whatever the solver sets."""
    if not fmu.n:
        return ABSENT, "no states"

    for value in (math.nan, 1e300, -1e300):
        run = _halfway(fmu)
        x = run.x
        x[0] = value

        try:
            run.set_x(x)
            bad = np.isnan(run.rates()).any()
        except Refused:
            continue

        if bad:
            return FAULT, f"{fmu.states[0].name} = {value:g}: NaN among the rates"

    return GOOD, "refused, or finite"


QUESTIONS = {
    question.__name__: question
    for question in (
        questions.runs,
        questions.reruns,
        questions.resets,
        questions.keeps_start_values,
        starts_as_told,
        questions.rolls_back,
        questions.travels,
        solved_as_in_co_simulation,
        keeps_states,
        forgets,
        has_nominals,
        watches_events,
        tells_times_of_events,
        completes_steps,
        tells_changes,
        questions.gives_directional_derivatives,
        questions.gives_adjoint_derivatives,
        questions.tells_dependencies,
        questions.refuses_unknown_references,
        refuses_other_sizes,
        is_honest_about_nan_in_states,
        questions.runs_in_threads,
    )
}
"""By name, in the order in which they are asked."""
