"""What acts in a joint of one freedom, and tables of forces."""

READING = ("linear", "monotone", "cubic")


def graph(dice, low, high, slope, at=0.0) -> tuple[list, list]:
    """Points and values of something that rises about as `slope` says, 0 about `at`, kinked."""
    n = dice.whole(3, 6)
    points = dice.ascending(n, low, high)
    values, value = [], slope * (low - at)

    for before, here in zip([points[0], *points], points):
        value += slope * (here - before) * dice.number(0.3, 1.7)
        values.append(round(value, 4))

    return points, values


def reading(dice) -> dict:
    """How a table of forces is read; now and then as by default."""
    return {"interpolation": dice.pick(READING)} if dice.chance(0.8) else {}


def spring(dice, kind, q):
    """A spring about where the joint stands."""
    stiffness = dice.number(0.5, 8.0) if dice.chance(0.9) else dice.number(100, 400)
    angular = kind == "revolute"

    if dice.chance(0.45):
        points, values = graph(dice, q - 1.2, q + 1.2, stiffness, q)
        key, points = _in_degrees(dice, points) if angular else ("position", points)
        return {"table": {key: points, "effort": values} | reading(dice)}

    table = {"stiffness": stiffness}

    if dice.chance(0.7):
        rest = q + dice.number(-0.5, 0.5)
        table |= degrees(dice, "rest", rest) if angular else {"rest": rest}

    return table


def _in_degrees(dice, points):
    if dice.chance(0.5):
        return "position", points
    return "position_deg", [57.3 * p for p in points]


def degrees(dice, key, value) -> dict:
    """An angle (rad) in rad, or about as much in whole degrees."""
    return {key: value} if dice.chance(0.5) else {f"{key}_deg": round(57.3 * value, 1)}


def damper(dice, key="effort"):
    """A damping constant, or a table over speed; one-way ones too."""
    if dice.chance(0.5):
        return dice.number(0.02, 1.0) if dice.chance(0.9) else 0.0

    if dice.chance(0.3):
        points, values = [-2.0, 0.0, 2.0], [-dice.number(0.5, 3.0), 0.0, 0.0]
    else:
        points, values = graph(dice, -2.5, 2.5, dice.number(0.1, 0.8))

    return {"table": {"speed": points, key: values} | reading(dice)}


def friction(dice) -> dict:
    """Dry friction; mostly with a smoothing that costs little."""
    table = {"coulomb": dice.number(0.05, 0.6)}

    if dice.chance(0.5):
        table["static"] = round(table["coulomb"] * dice.number(1.0, 1.6), 4)
    if dice.chance(0.4):
        table["stribeck_speed"] = dice.number(0.05, 0.3)
    if dice.chance(0.4):
        table["viscous"] = dice.number(0.0, 0.3)
    if dice.chance(0.85):
        table["smoothing_speed"] = dice.number(0.005, 0.05)

    return table


def stop(dice, kind, q) -> dict:
    """A stop at one or both ends, near enough to be hit; now and then the joint starts beyond it."""
    table, angular = {}, kind == "revolute"
    ends = dice.some(("lower", "upper"), 1)

    for end in ends:
        gap = dice.number(0.05, 0.5) if dice.chance(0.95) else -0.05
        value = round(q - gap if end == "lower" else q + gap, 4)
        table |= degrees(dice, end, value) if angular else {end: value}

    table["stiffness"] = dice.number(20, 300)
    if dice.chance(0.6):
        table["damping"] = dice.number(0.1, 3.0)

    return table


def add(dice, joint, taste):
    """Springs, dampers, friction, stops and an input to a joint of one freedom that has a use for them."""
    if dice.chance(taste["spring"]):
        joint.table["spring"] = spring(dice, joint.kind, joint.value)
    if dice.chance(taste["damper"]):
        joint.table["damper"] = damper(dice)
    if dice.chance(taste["friction"]):
        joint.table["friction"] = friction(dice)
    if dice.chance(taste["stop"]):
        joint.table["stop"] = stop(dice, joint.kind, joint.value)
    if not joint.driven and dice.chance(taste["input"]):
        effort = "torque" if joint.kind == "revolute" else "force"
        joint.table["input"] = effort if dice.chance(0.5) else [effort]
