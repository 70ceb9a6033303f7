"""What a scene tells, what comes in, texts, and the solver."""

from . import bodies, forces, shapes

REACTIONS = ("reaction_force", "reaction_moment", "reaction_force_body", "reaction_moment_body")
JOINT = {
    "revolute": ("angle", "speed", "acceleration", "power"),
    "prismatic": ("position", "speed", "acceleration", "power"),
    "screw": ("position", "speed", "angle", "angular_speed"),
    "cylindrical": ("position", "speed", "angle", "angular_speed"),
    "universal": ("angles", "speeds"),
    "planar": ("position", "angle", "velocity", "angular_speed"),
    "translation": ("position", "velocity"),
    "spherical": ("euler_parameters", "zyx", "zyx_rate", "omega", "alpha"),
    "free": ("position", "velocity", "euler_parameters", "zyx", "zyx_rate", "omega"),
    "point_on_curve": ("s", "s_rate", "tangent", "binormal", "normal"),
    "curve_on_curve": ("s", "s_rate", "tangent", "binormal", "normal"),
    "point_on_surface": ("s", "s_rate", "tangent", "binormal", "normal"),
    "frame_on_curve": ("s", "s_rate", "tangent", "binormal", "normal"),
    "frame_on_surface": ("s", "s_rate", "tangent", "binormal", "normal"),
    "surface_on_surface": ("s", "s_rate", "contact_point", "normal_force"),
    "rolling_surface": ("s", "s_rate", "contact_point", "normal_force", "friction_force"),
    "prescribed": (
        "position",
        "velocity",
        "euler_parameters",
        "zyx",
        "zyx_rate",
        "omega",
        "driver_force",
        "driver_torque",
    ),
}
EFFORTS = {part: f"{part}_effort" for part in ("spring", "damper", "friction", "stop", "input")}
SCENE = (
    "kinetic_energy", "potential_energy", "total_energy", "gravity_energy", "spring_energy", "input_power",
    "load_power", "driver_power", "dissipated_power", "linear_momentum", "angular_momentum", "center_of_mass",
    "constraint_gap", "constraint_rate", "multipliers",
)  # fmt: skip
MEASURES = (
    "distance", "distance_rate", "angle", "position", "velocity", "acceleration", "euler_parameters", "zyx",
    "zyx_rate", "omega",
)  # fmt: skip
TORSION = ("rate", "moment", "spring_moment", "damper_moment", "power")
HULL = (
    "volume", "center_of_buoyancy", "draught", "waterplane_area", "waterplane_center", "waterplane_moments",
    "force", "moment", "power",
)  # fmt: skip
FORCES = {
    "load": ("power",),
    "hydrostatics": HULL,
    "catenary": ("tension", "anchor_tension", "grounded_length", "force", "power"),
    "member": ("force", "power"),
    "rotor": ("thrust", "torque", "wind", "power"),
}
EXCITATION = ("excitation_force", "excitation_moment", "excitation_power")
DAMPING = ("damping_force", "damping_moment", "damping_power")
RADIATION = ("radiation_force", "radiation_moment", "radiation_power")
STRUT = ("length", "rate", "tension", "spring_force", "damper_force", "power")


class Teller:
    """Chooses what is told: everything, some, or next to nothing, as its scene does."""

    def __init__(self, dice, taste):
        self.dice, self.taste = dice, taste
        self.much = dice.weighted(taste["outputs"])

    def of(self, options):
        """Some of the options, as much as is told in this scene."""
        if self.much == "all":
            return list(options)
        return self.dice.some(options) if self.dice.chance({"some": 0.7, "few": 0.15}[self.much]) else []

    def output(self, options) -> dict:
        """A table with the key output, or an empty one."""
        told = self.of(options)
        return {"output": told} if told or self.dice.chance(0.03) else {}

    def joint(self, joint) -> dict:
        """Of a joint as drawn."""
        table, options = joint.table, list(JOINT.get(joint.kind, ()))

        if joint.kind in ("revolute", "prismatic"):
            options += [output for part, output in EFFORTS.items() if table.get(part)]
            options += ["effort", "driver_effort"] if joint.driven else []
        if joint.led and joint.kind != "prescribed":
            options += ["effort", "driver_power"]
        if joint.kind != "free":
            options += REACTIONS

        return self.output(options)

    def force(self, table, sea=None) -> dict:
        """Of a force; sea : that of the scene."""
        for kind, options in FORCES.items():
            if kind in table:
                return self.output(options)
        if "hydrodynamics" in table:
            # what is remembered nobody can know who is not told
            told = of_potential(table, sea)
            return {"output": told} if told else {}
        if "torsion" in table:
            # without the angle nobody can tell its turns
            return {"output": ["angle", *TORSION]}
        if "spring_damper" in table:
            return self.output([*STRUT, "input_force" if table.get("input") else "force"])
        return self.output(forces.WRENCH)

    def frame(self, input_too=True) -> dict:
        """Of a body or of a marker on one: what goes out, and maybe in."""
        dice, table = self.dice, self.output(bodies.OUTPUTS)

        if input_too and dice.chance(self.taste["input"]):
            table["input"] = dice.some(("force", "moment"), 1)
            if dice.chance(0.6):
                table["input_axes"] = dice.pick(["inertial", "body"])

        return table

    def decoration(self, often=0.04) -> dict:
        """A curve or a surface that nothing touches."""
        table = {}
        if self.dice.chance(often):
            table["curve"] = shapes.curve(self.dice).table
        if self.dice.chance(often):
            table["surface"] = shapes.surface(self.dice).table
        return table


def of_potential(table, sea):
    """What a body that makes waves can tell of them, and of those of the sea."""
    options = table["hydrodynamics"]
    feels = sea and "waves" in sea and options.get("excitation", True) is True
    damps = "damping" in options or "quadratic" in options
    told = () if options.get("radiation") is False else RADIATION
    return [*told, *(EXCITATION if feels else ()), *(DAMPING if damps else ())]


def texts(dice) -> dict:
    """Title and description."""
    table = {}
    if dice.chance(0.2):
        table["title"] = dice.pick(["A random mechanism", "Zufällig, mit Umlauten", "título"])
    if dice.chance(0.2):
        table["description"] = dice.pick(["Drawn by chance.", "Two lines:\nof text.", ""])
    return table


def solver(dice) -> dict:
    """Settings of the solver."""
    if dice.chance(0.2):
        return {}

    table = {}
    fixed = dice.chance(0.25)

    if dice.chance(0.7) or fixed:
        table["integrator"] = dice.pick(
            ["rk4", "ros2", "gauss"] if fixed else ["auto", "rk54", "rk853", "radau"]
        )
    if fixed:
        table["step"] = dice.pick([1e-3, 2e-3, 5e-3])
    else:
        if dice.chance(0.7):
            table["tolerance"] = dice.pick([1e-6, 1e-7, 1e-8, 1e-9, 1e-10])
        if dice.chance(0.4):
            table["absolute_tolerance"] = dice.pick([1e-8, 1e-9, 1e-10])
        if dice.chance(0.3):
            table["max_step"] = dice.pick([0.01, 0.02, 0.05])

    if dice.chance(0.6):
        table["formulation"] = dice.pick(["auto", "recursive", "embedding", "augmented"])
    if dice.chance(0.2):
        table["max_evaluations"] = dice.pick([1e5, 1e6])
    if dice.chance(0.3):
        table["closing_tolerance"] = dice.pick([1e-8, 1e-9, 1e-10])
    if dice.chance(0.4):
        table["output"] = dice.some(
            ["steps", "rejected_steps", "evaluations"] + ([] if fixed else ["estimated_error"])
        )

    return table
