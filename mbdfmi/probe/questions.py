"""The questions. Each takes an `Fmu` and returns (verdict, what was seen); its docstring is what is asked."""

import json
import math
import os
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np

from .answers import ABSENT, FAULT, GOOD, TOLD
from .fmu import REAL, Fmu, Refused, apart

CONTINUE = "continue"
"""What another process is asked for: to go on from a serialised state."""

MOST_PAIRS = 12
"""Of inputs that are moved one by one."""


def same(rows, others) -> tuple[str, str]:
    """Whether two runs are equal to the bit; else by how much they differ, of each output's largest value."""
    a, b = np.array(rows, float), np.array(others, float)

    if a.tobytes() == b.tobytes():
        return GOOD, "equal to the bit"

    return FAULT, f"differ by {apart(a, b):.1g}"


def runs(fmu: Fmu):
    """It runs, and says no NaN."""
    rows = fmu.new().drive()
    wrong = [name for name, bad in zip(fmu.columns(), np.isnan(np.array(rows, float)).any(axis=0)) if bad]
    if wrong:
        return FAULT, f"NaN: {', '.join(wrong)}"

    return GOOD, f"{len(rows)} steps of {fmu.step:g} s{fmu.told}"


def reruns(fmu: Fmu):
    """Another instance does the same, beside the first and after it was freed."""
    first = fmu.new("first")
    rows = first.drive()

    if not fmu.claims("canBeInstantiatedOnlyOncePerProcess"):
        beside = fmu.new("beside")
        answer = same(rows, beside.drive())
        if answer[0] == FAULT:
            return answer
        beside.free()

    first.free()
    return same(rows, fmu.new("after").drive())


def resets(fmu: Fmu):
    """After a reset it is as new."""
    run = fmu.new()
    rows = run.drive()
    run.call("reset")
    run.begin()
    return same(rows, run.drive())


def rolls_back(fmu: Fmu):
    """A state that was saved is the same when it is restored."""
    if not fmu.claims("canGetAndSetFMUstate", "canGetAndSetFMUState"):
        return ABSENT, "not claimed"

    run, half = fmu.new(), fmu.steps // 2
    run.drive(0, half)
    state = run.save()
    rows = run.drive(half)
    run.restore(state)
    verdict, seen = same(rows, run.drive(half))

    count, start = 100, time.perf_counter()
    for _ in range(count):
        run.restore(state)
        run.forget(run.save())
    cost = (time.perf_counter() - start) / count
    return verdict, f"{seen}; saved and restored in {cost * 1e6:.0f} us"


def travels(fmu: Fmu):
    """A serialised state goes on in another process."""
    if not fmu.claims("canSerializeFMUstate", "canSerializeFMUState"):
        return ABSENT, "not claimed"

    run, half = fmu.new(), fmu.steps // 2
    run.drive(0, half)
    data = run.serialise(run.save())
    rows = run.drive(half)

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "state"
        file.write_bytes(data)
        command = [sys.executable, "-m", "mbdfmi.probe", fmu.folder, fmu.kind, CONTINUE, str(file)]
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", env=os.environ)
        result = file.with_suffix(".json")

        if not result.is_file():
            why = f"falls (signal {-done.returncode})" if done.returncode < 0 else "fails"
            return FAULT, f"the other process {why}"

        told = json.loads(result.read_text())

    if isinstance(told, str):
        return FAULT, told

    verdict, seen = same(rows, told)
    return verdict, f"{seen}; {len(data)} bytes"


def go_on(fmu: Fmu, file: Path):
    """In another process: from the state in a file on; outputs, or why not, go to a file beside it."""
    told: list | str

    try:
        run = fmu.new()
        run.restore(run.deserialise(file.read_bytes()))
        told = run.drive(fmu.steps // 2)
    except Refused as refused:
        told = str(refused)

    file.with_suffix(".json").write_text(json.dumps(told))


def counts_time(fmu: Fmu):
    """It takes time as i H, as a sum of H, and H as a difference of times."""
    H, start = fmu.step, fmu.start
    products = [start + k * H for k in range(fmu.steps + 1)]
    sums = [start]
    for _ in range(fmu.steps):
        sums.append(sums[-1] + H)

    found = []
    for points, lengths in (
        (products, [H] * fmu.steps),
        (sums, [H] * fmu.steps),
        (products, list(np.diff(products))),
    ):
        run, rows = fmu.new(f"count{len(found)}"), []
        for k, (t, h) in enumerate(zip(points, lengths)):
            run.set(fmu.inputs, fmu.inputs_at(products[k]))
            run.step(t, float(h))
            rows.append(run.outputs())
        found.append(rows)

    worst = max(apart(found[0], other) for other in found[1:])
    if all(np.array(found[0]).tobytes() == np.array(other).tobytes() for other in found[1:]):
        return GOOD, "equal to the bit"

    return (GOOD if worst < 1e-9 else FAULT), f"differ by {worst:.1g}"


def takes_steps_of_any_size(fmu: Fmu):
    """Half the communication step tells how much its solver depends on it."""
    if not fmu.claims("canHandleVariableCommunicationStepSize"):
        return ABSENT, "not claimed"

    whole, half = fmu.new("whole"), fmu.new("half")
    rows, finer = [], []

    for t in fmu.times():
        for run, n, to in ((whole, 1, rows), (half, 2, finer)):
            run.set(fmu.inputs, fmu.inputs_at(t))
            for k in range(n):
                run.step(t + k * fmu.step / n, fmu.step / n)
            to.append(run.outputs())

    return TOLD, f"differs by {apart(rows, finer):.1g}"


def uses_input_derivatives(fmu: Fmu):
    """Derivatives of inputs act within a step."""
    if not (fmu.version == 2 and fmu.claims("canInterpolateInputs") and fmu.inputs):
        return ABSENT, "not claimed" if fmu.inputs else "no inputs"

    variable, fine = fmu.inputs[0], 20
    low, high = fmu.reach(variable)
    slope = float((high - low)[0]) / (fmu.steps * fmu.step)
    start = float(fmu.start_of(variable)[0])
    held, led, exact = (fmu.new(name) for name in ("held", "led", "exact"))
    ends = []

    for t in fmu.times():
        value = start + slope * (t - fmu.start)
        held.set([variable], [value])
        led.set([variable], [value])
        led.call("setRealInputDerivatives", [variable.valueReference], [1], [slope])
        held.step(t, fmu.step)
        led.step(t, fmu.step)
        for k in range(fine):
            exact.set([variable], [value + slope * fmu.step * (k + 0.5) / fine])
            exact.step(t + k * fmu.step / fine, fmu.step / fine)
        ends.append([run.outputs() for run in (held, led, exact)])

    without, with_them, wanted = (np.array(rows) for rows in zip(*ends))
    missed, met = apart(wanted, without), apart(wanted, with_them)
    if with_them.tobytes() == without.tobytes():
        return FAULT, "claimed, but they change nothing"

    return (GOOD if met < 0.5 * missed else FAULT), f"off by {met:.1g} with, {missed:.1g} without them"


def gives_output_derivatives(fmu: Fmu):
    """Derivatives of outputs are those that steps show."""
    if fmu.claimed.get("maxOutputDerivativeOrder", "0") == "0":
        return ABSENT, "not claimed"

    outputs = [v for v in fmu.outputs if v.type in REAL and fmu.size(v) == 1]
    if not outputs:
        return ABSENT, "no outputs"

    run, half, h = fmu.new(), fmu.steps // 2, fmu.step / 50
    run.drive(0, half)
    found = _output_derivatives(run, outputs)
    t, samples = fmu.times()[half], [run.get(outputs)]
    for k in range(2):
        run.step(t + k * h, h)
        samples.append(run.get(outputs))

    shown = (-3 * np.array(samples[0]) + 4 * np.array(samples[1]) - np.array(samples[2])) / (2 * h)
    if not np.isfinite(found).all():
        return FAULT, "not finite"

    off = float(np.abs(found - shown).max() / (np.abs(shown).max() + 1e-9))
    return (GOOD if off < 1e-2 else FAULT), f"off by {off:.1g}"


def _output_derivatives(run, outputs):
    keys = [v.valueReference for v in outputs]
    return np.array(
        list(
            run.call(
                "getRealOutputDerivatives" if run.fmu.version == 2 else "getOutputDerivatives",
                keys,
                [1] * len(keys),
            )
        )
    )


def gives_directional_derivatives(fmu: Fmu):
    """Directional derivatives are those that differences show."""
    if not fmu.claims("providesDirectionalDerivative", "providesDirectionalDerivatives"):
        return ABSENT, "not claimed"

    if absent := _nothing_to_derive(fmu):
        return absent

    run = fmu.new()
    run.drive(0, fmu.steps // 2)
    now = run.get(fmu.knowns)
    keys, worst = [v.valueReference for v in fmu.unknowns], (0.0, "")
    size = sum(map(fmu.size, fmu.unknowns))
    at = 0

    for v in fmu.knowns[:MOST_PAIRS]:
        n = fmu.size(v)
        seed = [1.0] + [0.0] * (n - 1)
        more = {"nSensitivity": size} if fmu.version == 3 else {}
        told = np.array(run.call("getDirectionalDerivative", keys, [v.valueReference], seed, **more))
        d = 1e-3 * (abs(now[at]) or 1.0)
        sides = []
        for step in (d, -d, d / 2, -d / 2):
            run.put(v, [now[at] + step, *now[at + 1 : at + n]])
            sides.append(np.array(run.get(fmu.unknowns)))
        run.put(v, now[at : at + n])
        shown = (8 * (sides[2] - sides[3]) - (sides[0] - sides[1])) / (6 * d)
        noise = 1e-9 * np.abs(sides[0]).max() / d
        off = float(np.abs(told - shown).max() / (np.abs(shown).max() + noise + 1e-12))
        worst = max(worst, (off, f", by {v.name}"))
        at += n

    off, where = worst
    return (GOOD, f"off by {off:.1g}") if off < 1e-4 else (FAULT, f"off by {off:.1g}{where}")


def gives_adjoint_derivatives(fmu: Fmu):
    """Adjoint derivatives are the directional ones, transposed."""
    if not fmu.claims("providesAdjointDerivatives"):
        return ABSENT, "not claimed"

    if not fmu.claims("providesDirectionalDerivatives"):
        return ABSENT, "nothing to compare"

    if absent := _nothing_to_derive(fmu):
        return absent

    run = fmu.new()
    run.drive(0, fmu.steps // 2)
    down, across = ([v.valueReference for v in variables] for variables in (fmu.unknowns, fmu.knowns))
    m, n = (sum(map(fmu.size, variables)) for variables in (fmu.unknowns, fmu.knowns))
    weights, seed = np.cos(1.0 + np.arange(m)), np.sin(1.0 + np.arange(n))
    along = run.call("getDirectionalDerivative", down, across, list(seed), nSensitivity=m)
    back = run.call("getAdjointDerivative", down, across, list(weights), nSensitivity=n)
    size = np.abs(weights * along).sum() + np.abs(seed * back).sum() + 1e-300
    off = float(abs(weights @ along - seed @ back) / size)
    return (GOOD if off < 1e-8 else FAULT), f"off by {off:.1g}"


def _nothing_to_derive(fmu):
    """An answer where there is nothing that derivatives are of, or by; else None."""
    for found, what in ((fmu.unknowns, "outputs"), (fmu.knowns, "inputs")):
        if not found:
            return ABSENT, f"no {what}"

    return None


def tells_dependencies(fmu: Fmu):
    """What is known acts at once on no output but those that say so."""
    if not fmu.knowns:
        return ABSENT, "no inputs"

    run = fmu.new()
    run.drive(0, fmu.steps // 2)
    structure = fmu.structure()
    watched = list({v.name: v for v in (*fmu.outputs, *fmu.unknowns)}.values())
    undeclared, unseen, at = set(), 0, 0
    now = run.get(fmu.knowns)

    for v in fmu.knowns[:MOST_PAIRS]:
        n = fmu.size(v)
        before = [run.get([o]) for o in watched]
        low, high = fmu.reach(v)
        run.put(v, [x + 0.37 * (b - a) for x, a, b in zip(now[at : at + n], low, high)])
        after = [run.get([o]) for o in watched]
        run.put(v, now[at : at + n])
        at += n
        for o, old, new in zip(watched, before, after):
            known = structure.get(o.name)
            declared = known is None or any(d.name == v.name for d in known)
            if old != new and not declared and o is not v:
                undeclared.add(f"{o.name} by {v.name}")
            unseen += declared and old == new

    if undeclared:
        return FAULT, f"not declared: {', '.join(sorted(undeclared)[:3])}"

    return GOOD, f"{unseen} declared that are not seen" if unseen else "as declared"


def refuses_wrong_steps(fmu: Fmu):
    """Steps backwards, and from another time, are refused."""
    wrong = {"backwards": (0.0, -fmu.step), "from another time": (7.3 * fmu.step, fmu.step)}
    return _refused(fmu, wrong)


def refuses_a_step_of_nan(fmu: Fmu):
    """A step of NaN seconds is refused."""
    return _refused(fmu, {"NaN": (0.0, math.nan)})


def _refused(fmu, wrong):
    """Whether steps (by how far from the right time, length) are refused."""
    accepted = []

    for name, (off, H) in wrong.items():
        run = fmu.new(name)
        run.drive(0, 3)

        try:
            run.step(fmu.times()[3] + off, H)
            accepted.append(name)
        except Refused:
            pass

    return (FAULT, f"accepted: {', '.join(accepted)}") if accepted else (GOOD, "refused")


def refuses_unknown_references(fmu: Fmu):
    """Value references that mean nothing are refused."""
    get = "getReal" if fmu.version == 2 else "getFloat64"

    try:
        fmu.new().call(get, [0xFFFFFFF0])
    except Refused:
        return GOOD, "refused"

    return FAULT, "accepted"


def keeps_start_values(fmu: Fmu):
    """Parameters have their start values, and others that are set before."""
    if not fmu.parameters:
        return ABSENT, "no parameters"

    run, chosen = fmu.new(), fmu.parameters[:8]
    wrong = [
        f"{v.name} starts otherwise"
        for v in fmu.parameters
        if not np.allclose(run.get([v]), fmu.start_of(v), rtol=1e-12, atol=0)
    ]

    # by little: any of them must still be good for a start
    values = [[x * 1.001 if x else 0.0 for x in fmu.start_of(v)] for v in chosen]
    run = fmu.new("other", list(zip(chosen, values)))
    wrong += [
        f"{v.name} was lost" for v, x in zip(chosen, values) if not np.allclose(run.get([v]), x, rtol=1e-12)
    ]
    return (
        (FAULT, "; ".join(wrong[:3])) if wrong else (GOOD, f"{len(fmu.parameters)} read, {len(chosen)} set")
    )


def is_honest_about_nan(fmu: Fmu):
    """No NaN is handed out as good, whatever goes in."""
    if not fmu.inputs:
        return ABSENT, "no inputs"

    for value in (math.nan, 1e300, -1e300):
        run = fmu.new(f"wild {value}")
        run.drive(0, 3)

        try:
            run.set(fmu.inputs[:1], [value] * fmu.size(fmu.inputs[0]))
            run.step(fmu.times()[3], fmu.step)
            bad = [name for name, x in zip(fmu.columns(), run.outputs()) if math.isnan(x)]
        except Refused:
            continue

        if bad:
            return FAULT, f"{fmu.inputs[0].name} = {value:g}: NaN in {', '.join(bad[:3])}"

    return GOOD, "refused, or finite"


def runs_in_threads(fmu: Fmu):
    """Four instances in four threads do as one."""
    if fmu.claims("canBeInstantiatedOnlyOncePerProcess"):
        return ABSENT, "one instance a process"

    rows = fmu.new("alone").drive()
    found: list = [None] * 4
    loading = threading.Lock()  # FMPy changes the folder of the process while it loads a library

    def work(k):
        try:
            with loading:
                run = fmu.new(f"thread {k}")
            found[k] = run.drive()
        except Refused as refused:
            found[k] = str(refused)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()

    for told in found:
        if isinstance(told, str):
            return FAULT, told
        if (answer := same(rows, told))[0] == FAULT:
            return answer

    return GOOD, "equal to the bit"


QUESTIONS = {
    question.__name__: question
    for question in (
        runs,
        reruns,
        resets,
        keeps_start_values,
        rolls_back,
        travels,
        counts_time,
        takes_steps_of_any_size,
        uses_input_derivatives,
        gives_output_derivatives,
        gives_directional_derivatives,
        gives_adjoint_derivatives,
        tells_dependencies,
        refuses_wrong_steps,
        refuses_a_step_of_nan,
        refuses_unknown_references,
        is_honest_about_nan,
        runs_in_threads,
    )
}
"""By name, in the order in which they are asked."""
