"""Laws of commanded motion (docs/scene.md): what is continued exactly is met, and nothing jumps with it."""

import numpy as np

from mbdfmi.scene import fmi_name

from .compare import groups
from .findings import Finding
from .ways import ARRIVING, LEAVING, listed

MET = 1e-7  # of the largest position; steps as unequal as 1 to 10,000 leave no digits of a polynomial
KNOWN = 6  # steps after which a cubic is known, and is seen to be the best of all orders
STRAIGHT = 1e-7  # of the largest position

OUTPUT = {"position_command": "position", "angle_command": "angle", "s_command": "s"}
SPEEDS = ("speed_command", "s_rate_command")
ACTS = ("damper", "spring", "friction", "stop", "input", "driver")


def met(plan, run):
    """Findings where a joint does not arrive at what is commanded, its courses being cubics of which positions alone are told."""
    if run.way.pattern[0] in ("tiny", "union"):
        return []

    columns = {name: k for k, name in enumerate(run.names)}
    begun = np.cumsum(np.array(run.phases) == LEAVING)
    rows = np.flatnonzero((np.array(run.phases) == ARRIVING) & (begun >= KNOWN))
    found = []

    for name, signal in plan.signals.items():
        owner, _, quantity = name.rpartition(".")
        output = f"{owner}.{OUTPUT.get(quantity)}"

        if (
            output not in columns
            or signal.told
            or any(f"{owner}.{speed}" in plan.signals for speed in SPEEDS)
        ):
            continue

        for row in rows:
            # before what is told there holds: where the last step led
            told, t = run.values[row][columns[output]], run.times[row]
            wanted = signal.value(t, 0)
            allowed = MET * max(1.0, abs(wanted))

            if not abs(told - wanted) <= allowed:
                text = "where the step that ends there led, and what is commanded there"
                found.append(Finding("commands", str(run.way), output, t, told, wanted, allowed, text))
                break

    return found


def straight(data, plan, run):
    """Findings where a body on which nothing acts does not move straight on at the speed it began with."""
    if not run.whole or not _speeds_are_told(data, plan):
        return []

    columns, values = groups(run.names), np.array(run.values)
    rows = _settled(run)
    first = int(np.flatnonzero(np.array(run.phases) == LEAVING)[0])
    found = []

    for name in _free(data):
        r, v = (columns.get(f"{fmi_name(name)}.{quantity}") for quantity in ("position", "velocity"))

        if r is None or v is None or not rows:
            continue

        line = values[first][r] + np.outer(np.array(run.times)[rows] - run.times[first], values[first][v])
        off = np.abs(values[rows][:, r] - line)
        allowed = STRAIGHT * max(1.0, np.abs(values[:, r]).max())
        k, c = np.unravel_index(off.argmax(), off.shape)

        if off[k, c] > allowed:
            text = "nothing acts on it"
            found.append(Finding("straight", str(run.way), run.names[r[c]], run.times[rows[k]],
                                 values[rows[k]][r[c]], line[k, c], allowed, text))  # fmt: skip

    return found


def _settled(run):
    """Rows where a step ends that is no shorter than the one before: what the commands were off is led back by then."""
    times, phases = np.array(run.times), np.array(run.phases)
    leaving = np.flatnonzero(phases == LEAVING)
    ends = np.append(times[leaving], times[-1])
    steps = np.diff(ends)
    longer = np.flatnonzero(steps[1:] >= steps[:-1] * (1.0 - 1e-9)) + 1
    at = ends[longer + 1]
    rows = np.flatnonzero(phases == ARRIVING)
    return [row for row in rows if np.any(np.abs(times[row] - at) <= 1e-9 * times[-1])]


def _free(data):
    """Bodies held by nothing, with the centre of mass at their origin: a free or translation joint to the ground, and nothing
    that acts."""
    if np.any(data.get("gravity", [0, 0, -9.81])) or data.get("central_gravity") or data.get("coupling"):
        return []

    ends = [listed(part.get("between", part.get("on", []))) for part in data.get("force", {}).values()]
    forced = {end.partition(".")[0] for own in ends for end in own}
    held = {}

    for joint in data.get("joint", {}).values():
        ends = [end.partition(".")[0] for end in joint["between"]]
        loose = ("free" in joint or "translation" in joint) and ends[0] == "ground"

        for end in ends:
            held.setdefault(end, []).append(loose and not any(part in joint for part in ACTS))

    bodies = data["body"].items()
    still = [name for name, body in bodies if not np.any(body.get("com", 0.0)) and not body.get("solid")]
    return [
        name
        for name in still
        if held.get(name) == [True] and name not in forced and not _is_pushed(data["body"][name])
    ]


def _is_pushed(body):
    return bool(body.get("input")) or any(marker.get("input") for marker in body.get("marker", {}).values())


def _speeds_are_told(data, plan):
    """Whether inputs that move the ground tell its speeds, or all derivatives: else the start does not know them."""
    told = {name.partition("[")[0] for name in plan.signals if name.startswith("ground.")}
    bare = any(not signal.told for name, signal in plan.signals.items() if name.startswith("ground."))
    moves, turns = "ground.position" in told, bool({"ground.euler_parameters", "ground.zyx"} & told)
    return not bare or (moves <= ("ground.velocity" in told) and turns <= ("ground.omega" in told))
