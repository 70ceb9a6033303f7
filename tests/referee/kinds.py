"""Small scenes of every kind of thing that the schema has, as dicts, for the independent route's tests."""

import copy

import numpy as np

from .making.looks import WEDGE

BODY = {"mass": 1.3, "com": [0.1, -0.2, 0.3], "inertia": [0.4, 0.5, 0.6, 0.02, -0.03, 0.01]}
TILTED = {"zyx_deg": [20, -35, 50], "position": [0.2, -0.1, 0.3]}
WAVE = [0.0, 0.3, 0.5, 0.9, 1.4, 2.0]
VALUES = [0.1, 0.4, -0.2, 0.3, 0.7, 0.2]


def scene(**tables):
    """A scene of these tables, with weight in no special direction."""
    return {"name": "kinds", "gravity": [0.5, -1.0, -9.0], "solver": {"tolerance": 1e-11}} | tables


def arm(**more):
    """A body with a marker where the next joint is."""
    return (
        BODY
        | {"marker": {"end": TILTED | {"position": [0.3, 0.2, -0.4]}, "side": {"position": [0.1, 0.5, 0.2]}}}
        | more
    )


def pair(first, second, **tables):
    """Two bodies one after the other on a ground with a tilted marker; first, second :
    their joints but for the ends."""
    joints = {
        "one": {"between": ["ground.post", "a"]} | first,
        "two": {"between": ["a.end", "b.side"]} | second,
    }
    ground = {"marker": {"post": TILTED}} | tables.pop("ground", {})
    return scene(ground=ground, body={"a": arm(), "b": arm()}, joint=joints, **tables)


def hinge(**more):
    return {"revolute": {"axis": [1, 2, -1]}} | more


def slide(**more):
    return {"prismatic": {"axis": "-y"}} | more


def drivers():
    """Name -> scene: every way to drive a joint, in a chain, and in a loop."""
    angular = {
        "constant": {"constant_speed_rpm": 20},
        "hold": {"hold": True},
        "harmonic": {"harmonic": {"amplitude_deg": 30, "frequency": 1.5, "phase_deg": 40, "mean_deg": 10}},
        "harmonics": {
            "harmonics": {
                "amplitude": [0.3, 0.1],
                "frequency": [0.7, 2.1],
                "phase_deg": [10, -70],
                "mean": 0.2,
            }
        },
        "polynomial": {"polynomial": {"coefficients_deg": [10, 20, -30, 5]}},
        "ramp": {"ramp": {"time": [-0.3, 0.6], "position_deg": [-20, 50]}},
    }
    linear = {
        "constant": {"constant_speed": 0.4},
        "harmonic": {"harmonic": {"amplitude": 0.3, "frequency": 1.1, "mean": 0.2}},
        "harmonics": {"harmonics": {"amplitude": [0.3, 0.1], "frequency": [0.7, 2.1]}},
        "polynomial": {"polynomial": {"coefficients": [0.1, 0.3, 0.4, -0.2, 0.1]}},
        "ramp": {"ramp": {"time": [0.0, 0.2], "position": [0.1, 0.3]}},
    }

    for read in ("linear", "cubic", "quintic", "smooth"):
        angular[f"table {read}"] = {
            "table": {"time": WAVE, "position_deg": [50 * x for x in VALUES], "interpolation": read}
        }
        angular[f"speeds {read}"] = {
            "speed_table": {"time": WAVE, "speed_rpm": [9 * x for x in VALUES], "interpolation": read}
        }
        linear[f"table {read}"] = {"table": {"time": WAVE, "position": VALUES, "interpolation": read}}
        linear[f"speeds {read}"] = {"speed_table": {"time": WAVE, "speed": VALUES, "interpolation": read}}

    found = {}

    for name, driver in angular.items():
        start = {"start": {"angle_deg": 35}} if name.startswith(("constant", "hold", "speeds")) else {}
        found[f"angular {name}"] = pair(
            hinge(start={"angle": 0.4, "speed": 1.0}), hinge(driver=driver, **start)
        )

    for name, driver in linear.items():
        start = {"start": {"position": 0.3}} if name.startswith(("constant", "hold", "speeds")) else {}
        found[f"linear {name}"] = pair(slide(driver=driver, **start), hinge(start={"speed": -2.0}))

    return found


def grounds():
    """Name -> scene: every motion of the ground, with a body on it, one that is free,
    and water that rests in it."""
    place = [[0.1 * np.sin(t + k) for k in range(3)] for t in WAVE]
    angles = [[20 * np.sin(t), 10 * t, -15 * np.cos(t)] for t in WAVE]
    motions = {
        "acceleration": {"acceleration": [0.3, -0.5, 1.0], "velocity": [0.2, 0, 0.1], "position": [1, 2, 3]},
        "rotation": {
            "rotation": {"axis": [1, 1, 3], "speed_deg": 80, "point": [0.3, 0.4, 0.5], "angle_deg": 25}
        },
        "orbit": {"orbit": {"radius": 3.0, "rate": -0.8, "normal": [1, 0, 2], "phase_deg": 70}},
        "orbit that keeps its axes": {
            "orbit": {"radius": 3.0, "rate": 0.8, "normal": "x", "pointing": False}
        },
        "elliptic orbit": {
            "elliptic_orbit": {
                "semi_major_axis": 3.0,
                "eccentricity": 0.4,
                "period": 9.0,
                "inclination_deg": 40,
                "node_deg": 20,
                "periapsis_deg": -70,
                "true_anomaly_deg": 120,
            }
        },
        "elliptic orbit that keeps its axes": {
            "elliptic_orbit": {
                "semi_major_axis": 3.0,
                "eccentricity": 0.7,
                "mu": 8.0,
                "mean_anomaly_deg": -20,
                "pointing": False,
            }
        },
        "cubic": {"table": {"time": WAVE, "position": place, "zyx_deg": angles, "interpolation": "cubic"}},
        "smooth": {"table": {"time": WAVE, "position": place, "zyx_deg": angles}},
    }
    start = {
        "position": [0.5, 0.4, 1.0],
        "zyx_deg": [20, 30, 40],
        "velocity": [1, -0.5, 0.3],
        "omega_body": [1, 2, -1],
    }
    matrix = np.diag([2.0, 3, 4, 0.5, 0.6, 0.7])
    matrix[0, 4] = matrix[4, 0] = 0.3
    found = {}

    for k, (name, motion) in enumerate(motions.items()):
        water = {
            "added_mass": matrix.tolist(),
            "damping": (0.3 * matrix).tolist(),
            "axes": ("first", "heading", "body")[k % 3],
        }
        found[name] = scene(
            ground={"motion": motion, "marker": {"post": TILTED, "sea": {"zyx_deg": [10, 5, -20]}}},
            body={"a": arm(), "b": arm(), "f": arm()},
            joint={
                "one": {"between": ["ground.post", "a"]} | hinge(start={"speed": 1.0}, damper=0.1),
                "weld": {"fixed": {}, "between": ["a.end", "b"]},
                "float": {"free": {}, "between": ["ground", "f.side"], "start": start},
            },
            force={
                "water": {"linear": water, "between": ["ground.sea", "f.end"]},
                "tether": {"spring_damper": {"stiffness": 30, "damping": 1, "rest_length": 0.2},
                           "between": ["inertial", "f"]},
            },
            measure={"m": {"between": ["inertial", "ground.post"], "output": []},
                     "n": {"between": ["f.end", "b.end"], "output": []}},
        )  # fmt: skip

    return found


def efforts():
    """Name -> scene: what acts in joints, with tables of every reading, beyond their ends too."""
    found = {}
    x, y = [-0.6, -0.2, 0.1, 0.3, 0.8], [-3.0, -1.0, 0.5, 0.7, 2.5]

    for read in ("linear", "monotone", "cubic"):
        for where, q in (("inside", 0.25), ("below", -1.5), ("above", 1.9)):
            spring = {"table": {"position_deg": [57.3 * k for k in x], "effort": y, "interpolation": read}}
            damper = {"table": {"speed": x, "effort": y, "interpolation": read}}
            strut = {
                "table": {
                    "length": [0.2, 0.7, 1.1, 1.9],
                    "force": [-2.0, 1.0, 3.0, 4.0],
                    "interpolation": read,
                },
                "damping": {"table": {"speed": x, "force": y, "interpolation": read}},
            }
            found[f"{read} {where}"] = pair(
                hinge(spring=spring, damper=damper, start={"angle": q, "speed": -q}),
                slide(
                    spring={"table": {"position": x, "effort": y, "interpolation": read}},
                    start={"position": q, "speed": 0.4},
                ),
                force={
                    "rope": {"spring_damper": strut, "between": ["ground.post", "b.end"], "input": "force"}
                },
            )

    for k, ground in enumerate(({}, {"motion": {"rotation": {"axis": [1, 1, 3], "speed_deg": 80}}})):
        found[f"rotors {k}"] = pair(
            hinge(
                turning={"inertia": 0.02, "ratio": -12.0},
                damper=0.1,
                start={"angle": 0.4, "speed": 1.0},
                input="torque",
            ),
            slide(turning={"inertia": 0.03, "ratio": 9.0}, start={"position": 0.1, "speed": -0.6}),
            ground=ground,
        )
        driver = {"driver": {"harmonic": {"amplitude": 0.4, "frequency": 1.2}}}
        found[f"driven rotors, backwards {k}"] = pair(
            slide(
                turning={"inertia": 0.02, "ratio": -12.0},
                between=["a", "ground.post"],
                **(driver if k else {}),
            ),
            hinge(
                turning={"inertia": 0.03, "ratio": 9.0}, between=["b.side", "a.end"], **({} if k else driver)
            ),
            ground=ground,
        )

    friction = {"coulomb": 0.7, "static": 1.1, "stribeck_speed": 0.3, "viscous": 0.2, "smoothing_speed": 0.15}

    for q, v in ((0.7, 0.9), (0.7, -3.0), (-0.9, -0.4), (-0.9, 4.0), (0.1, 0.05)):
        stop = {"lower_deg": -25, "upper": 0.5, "stiffness": 40, "damping": 6}
        found[f"friction and stops at {q}, {v}"] = pair(
            hinge(
                friction=friction,
                stop=stop,
                spring={"stiffness": 3, "rest_deg": 20},
                start={"angle": q, "speed": v},
            ),
            slide(
                friction={"coulomb": 0.4},
                stop={"upper": 0.5, "stiffness": 30},
                start={"position": q, "speed": v},
                damper=0.3,
            ),
        )

    return found


def bodies():
    """Name -> scene: solids of every kind, frames written in every way."""
    solids = [
        {"sphere": {"radius": 0.2, "density": 800}, "position": [0.1, 0.2, 0.3]},
        {"box": {"size": [0.2, 0.3, 0.5], "mass": 3}, "axis_angle": {"axis": [1, 2, 3], "angle_deg": 40}},
        {"cylinder": {"radius": 0.1, "length": 0.6, "density": 500}, "axis": "x", "zyx_deg": [10, 20, 30]},
        {
            "tube": {"radius": 0.2, "inner_radius": 0.15, "length": 0.4, "mass": 2},
            "axis": [1, 1, 0],
            "position": [0, 0.3, 0],
        },
        {"point": {"mass": 0.7}, "position": [0.5, -0.3, 0.1]},
        {"mesh": {"file": WEDGE, "scale": 0.001, "density": 900}, "zyx_deg": [10, 20, 30]},
    ]
    frames = {
        "e": {"euler_parameters": [0.1, 0.2, 0.3, 0.9273618495495704]}, "z": {"zyx_rad": [0.3, -0.4, 0.5]},
        "q": {"axis_angle": {"axis": "-y", "angle_rad": 0.7}},
        "x": {"axes": {"z": [1, 1, 1], "x": [1, 0, 0]}},
        "y": {"axes": {"y": "-z", "x": [1, 2, 0]}},
    }  # fmt: skip
    inertia = BODY | {
        "inertia": [[0.4, 0.02, 0], [0.02, 0.5, 0.01], [0, 0.01, 0.6]],
        "inertia_axes": {"zyx_deg": [10, 20, 30]},
    }
    found = {}

    for k, frame in enumerate(frames):
        part = {"solid": solids[k:] + solids[:1] if k != 1 else solids[1], "marker": frames}
        found[f"frame {frame}"] = scene(
            body={"a": part, "b": inertia | {"marker": {"m": {"zyx_deg": [1, 2, 3],
                                                              "position": [0.3, 0, 0]}}}},
            joint={
                "one": {"universal": {"axes": [[1, 1, 0], [0, 0, 1]]}, "between": ["ground", f"a.{frame}"],
                        "start": {"angles_deg": [20, 30], "speeds": [1, 2]}},
                "two": {"planar": {"normal": [1, 2, 3]}, "between": [f"a.{frame}", "b.m"],
                        "start": {"position": [0.3, 0.4], "angle_deg": 500, "velocity": [1, 2],
                                  "angular_speed_rpm": 30}},
            },
        )  # fmt: skip

    return found


def forces():
    """Name -> scene: loads, bushings, central gravity, inputs."""
    found = {}
    table = {"time": [0.0, 0.03, 0.08, 0.2], "force": [[1, 2, 3], [0, 1, 5], [-2, 0, 1], [4, 4, 4]]}

    for read in ("linear", "steps", "monotone", "cubic"):
        load = {"table": table | {"moment": table["force"][::-1], "interpolation": read}, "axes": "body"}
        mount = {"stiffness": [100, 200, 300, 10, 20, 30], "damping": (np.eye(6) + 0.2).tolist()}
        found[f"load {read}"] = pair(
            {"spherical": {}, "input": "torque", "start": {"zyx_deg": [30, 40, 50], "omega": [1, -2, 0.5]}},
            {
                "cylindrical": {"axis": [0, 1, 1]},
                "input": ["force", "torque"],
                "start": {"position": 0.2, "speed": 0.3},
            },
            force={
                "push": {"load": load, "on": "b.end"},
                "pull": {"load": {"force": [1, 2, 3], "moment": [3, 2, 1]}, "on": "a.side"},
                "mount": {"bushing": mount, "between": ["a.side", "b.end"]},
                "stay": {"spring_damper": {"stiffness": 20, "damping": 1}, "between": ["ground", "b"]},
            },
        )

    start = {"position": [3.0, 0.5, 0], "velocity": [0, 1, 0.4], "omega": [0.1, 0.2, 0.3]}
    body = arm(input=["force", "moment"], input_axes="body")
    body["marker"] = {"tip": TILTED | {"input": ["force", "moment"], "input_axes": "body"}}
    found["central"] = scene(
        central_gravity={"mu": 9.0},
        body={"a": body},
        joint={"f": {"free": {}, "between": ["a.tip", "ground"], "start": start}},
    )
    del found["central"]["gravity"]
    found["central, with its gradient"] = found["central"] | {
        "central_gravity": {"mu": 9.0, "gradient": True}
    }
    hulls = {
        "box": {"box": {"size": [0.6, 0.4, 0.3]}, "position": [0.1, 0, 0], "zyx_deg": [10, 20, 30]},
        "cylinder": {"cylinder": {"radius": 0.3, "length": 0.8, "sides": 7}},
        "mesh": {"mesh": {"file": WEDGE, "scale": 0.004}, "position": [0, 0, -0.2]},
    }

    for name, hull in hulls.items():
        found[f"hull, {name}"] = pair(
            hinge(start={"angle": 0.4, "speed": 2.0}),
            slide(start={"speed": 0.2}),
            gravity=[0, 0, -9.0],
            sea={"density": 30.0},
            force={f"water {k}": {"hydrostatics": hull, "on": on} for k, on in enumerate(("a.side", "b"))},
        )

    turns = {
        "position_deg": [-900.0, 0.0, 60.0, 900.0],
        "effort": [-9.0, 0.0, 2.0, 11.0],
        "interpolation": "monotone",
    }

    for k, options in enumerate(({"stiffness": 3, "rest_deg": 500, "damping": 0.3}, {"table": turns})):
        found[f"torsion {k}"] = pair(
            hinge(start={"angle": 0.4, "speed": 9.0}),
            slide(start={"speed": 0.2}),
            force={"bar": {"torsion": options, "between": ["ground.post", "b.end"][:: (-1) ** k]}},
        )

    return found


def couplings():
    """Name -> scene: couplings of every kind, with an offset and without; a screw in a chain."""
    found = {}
    kinds = {
        "gear": {"gear": {"ratio": -1.7, "offset_deg": 30}}, "free gear": {"gear": {"ratio": 0.6}},
        "rack": {"rack": {"radius": 0.3, "offset": 0.1}}, "screw": {"screw": {"pitch": 0.4, "offset": 0.2}},
        "linear": {"linear": {"ratio": 2.5, "offset": -0.1}},
    }  # fmt: skip

    for name, coupling in kinds.items():
        second = hinge() if "gear" in name else slide()
        found[name] = pair(
            hinge(start={"angle": 0.3, "speed": 1.2}, input="torque"), second,
            coupling={"c": coupling | {"between": ["one", "two"]}},
        )  # fmt: skip

    found["driven gear"] = pair(
        hinge(driver={"constant_speed": 2.0}),
        hinge(),
        coupling={"c": {"gear": {"ratio": 3}, "between": ["one", "two"]}},
    )
    three = {"between": ["b.end", "c"], "start": {"speed": 0.4}}
    differential = {"linear": {"coefficients": [1, 1, -2]}, "between": ["one", "two", "three"]}
    found["differential"] = pair(hinge(start={"angle": 0.3, "speed": 1.2}, input="torque"), hinge())
    found["differential"]["body"]["c"] = arm()
    found["differential"]["joint"]["three"] = hinge(**three)
    found["differential"]["coupling"] = {"c": differential}
    found["screw joint"] = pair(
        {
            "screw": {"axis": [1, 2, 1], "pitch": -0.5},
            "start": {"angle_deg": 400, "angular_speed_deg": 50},
            "input": "torque",
        },
        {"translation": {}, "start": {"position": [0.3, 0.1, 0], "velocity": [0.1, 0.2, 0.3]}},
    )
    return found


def contacts():
    """Name -> scene: a point on every curve and surface, cams on followers."""
    turns = np.linspace(0, 2 * np.pi, 9)[:-1]
    ring = [[0.5 * np.cos(a), 0.35 * np.sin(a), 0.1 * np.sin(2 * a)] for a in turns]
    path = [[x, 0.3 * np.sin(2 * x), 0.1 * x * x] for x in np.linspace(-1, 1, 7)]
    flat = [[x, 0.3 * np.sin(2 * x)] for x in np.linspace(-1, 1, 7)]
    curves = {
        "line": {"line": {}}, "circle": {"circle": {"radius": 0.6}},
        "parabola": {"parabola": {"coefficient": 0.7}},
        "cycloid": {"cycloid": {"radius": 0.4}}, "ring": {"spline": {"points": ring, "closed": True}},
        "path": {"spline": {"points": path}},
        "table": {"table": {"s": np.linspace(0, 3, 7).tolist(), "points": path}},
    }  # fmt: skip
    grid = np.linspace(-1, 1, 5)
    hill = [[[x, y, 0.2 * np.cos(2 * x) * np.cos(y) + 0.1 * x] for y in grid] for x in grid]
    surfaces = {
        "plane": {"plane": {}}, "sphere": {"sphere": {"radius": 0.7}},
        "ellipsoid": {"ellipsoid": {"semi_axes": [0.8, 0.6, 0.7]}},
        "cylinder": {"cylinder": {"radius": 0.5}},
        "torus": {"torus": {"radius": 0.8, "tube": 0.3}},
        "prism": {"prism": {"profile": {"spline": {"points": flat}}}},
        "table": {"table": {"s1": grid.tolist(), "s2": grid.tolist(), "points": hill}},
    }  # fmt: skip
    start = {"position": [0.35, 0.3, 0.3], "velocity": [0.3, 0.4, 0.1], "omega": [1, 2, 3]}
    found = {}

    for what, shapes in (("curve", curves), ("surface", surfaces)):
        for name, shape in shapes.items():
            found[f"point on {what} {name}"] = scene(
                ground={"marker": {"track": {"zyx_deg": [10, 20, 15], what: shape}}},
                body={"a": arm()},
                joint={
                    "f": {"free": {}, "between": ["ground", "a"], "start": start},
                    "c": {f"point_on_{what}": {}, "between": ["ground.track", "a.end"]},
                },
            )

            spin = {"spin": "free"} if name in ("circle", "path", "torus", "plane") else {}
            side = (
                {"side": [0.1, 0.2, 1]}
                if what == "curve" and name in ("ring", "path", "table", "circle")
                else {}
            )
            found[f"frame on {what} {name}"] = copy.deepcopy(found[f"point on {what} {name}"])
            found[f"frame on {what} {name}"]["joint"]["c"] = {
                f"frame_on_{what}": spin | side, "between": ["ground.track", "a.end"],
            }  # fmt: skip

    for name in ("circle", "ring", "parabola"):
        shape = (
            {"spline": {"points": [point[:2] for point in ring], "closed": True}}
            if name == "ring"
            else curves[name]
        )
        follower = {"circle": {"radius": 0.1}} if name != "circle" else {"line": {}}
        found[f"cam {name}"] = scene(
            ground={"marker": {"axle": {"zyx_deg": [20, 10, 0]}}},
            body={"cam": BODY | {"marker": {"m": {"curve": shape, "position": [0.1, 0, 0]}}},
                  "f": BODY | {"marker": {"m": {"curve": follower, "position": [0.0, 0.0, 0.2]}}}},
            joint={
                "turn": {"revolute": {}, "between": ["ground.axle", "cam"],
                         "start": {"angle": 0.2, "speed": 2.0}},
                "slide": {"prismatic": {"axis": "y"}, "between": ["ground.axle", "f"],
                          "start": {"position": 0.7}},
                "touch": {"curve_on_curve": {}, "between": ["cam.m", "f.m"]},
            },
        )  # fmt: skip

    return found


def commands():
    """Name -> scene: joints and the ground commanded by inputs."""
    found = {}

    for k, told in enumerate((["position"], ["position", "speed"], True)):
        ends = {"input": told if told is True else ["angle", *told[1:]]}
        found[f"joints {k}"] = pair(hinge(driver=ends), slide(driver={"input": told}))

    # whose accelerations no output tells
    pose = {"x": {"input": True}, "pitch": {"input": True}, "roll": {"constant_speed": 0.5}}
    found["pose"] = pair(hinge(start={"speed": 1.0}), {"prescribed": {}, "driver": pose})
    found["along a curve"] = copy.deepcopy(contacts()["frame on curve ring"])
    found["along a curve"]["joint"]["c"]["driver"] = {"input": True}

    places = {name: {"position": place} for name, place in zip("xyz", np.eye(3).tolist())}
    seen = {name: {"between": ["inertial", f"ground.{name}"], "output": []} for name in "xyz"}

    for k, told in enumerate(
        (True, ["position", "zyx"], ["position", "velocity", "zyx", "omega"], ["euler_parameters"])
    ):
        found[f"ground {k}"] = scene(
            ground={"motion": {"input": told}, "marker": places},
            body={"a": arm()},
            joint={"one": {"between": ["ground.x", "a"]} | hinge(start={"speed": 1.0})},
            measure=seen | {"g": {"between": ["inertial", "ground"], "output": []}},
        )

    return found


def led():
    """Name -> scene: all six freedoms prescribed, at the end and in the middle of a chain, and drivers along curves."""
    wave = {"harmonic": {"amplitude": 0.3, "frequency": 1.1, "mean": 0.2}}
    course = {"polynomial": {"coefficients_deg": [10, 20, -30, 5]}}
    poses = {
        "held": {"driver": {"x": wave}, "start": {"position": [0.0, 0.2, -0.3], "zyx_deg": [30, 100, -20]}},
        "turned": {
            "driver": {"yaw": course, "pitch": {"constant_speed": 1.5}, "roll": {"speed_table": {"time": WAVE, "speed": VALUES}}},
            "start": {"zyx_rad": [0.0, 0.4, 0.9]},
        },
        "all": {
            "driver": {
                "x": wave, "y": {"table": {"time": WAVE, "position": VALUES}}, "z": {"hold": True},
                "yaw": {"constant_speed_rpm": 20}, "pitch": course, "roll": {"ramp": {"time": [-0.3, 0.6], "position_deg": [-20, 50]}},
            },
        },
    }  # fmt: skip
    found = {}

    for name, pose in poses.items():
        found[f"pose {name}"] = pair({"prescribed": {}} | pose, hinge(start={"angle": 0.4, "speed": 1.0}))
        found[f"pose {name} behind"] = pair(hinge(start={"speed": 2.0}), {"prescribed": {}} | pose)

    curves = contacts()

    for kind, curve in (("point", "circle"), ("point", "ring"), ("frame", "path"), ("frame", "circle")):
        for way, driver in (("wave", wave), ("speed", {"constant_speed": 0.4}), ("hold", {"hold": True})):
            found[f"{kind} on {curve} {way}"] = copy.deepcopy(curves[f"{kind} on curve {curve}"])
            start = {} if way == "wave" else {"start": {"s": 0.2}}
            found[f"{kind} on {curve} {way}"]["joint"]["c"] |= {"driver": driver} | start

    return found


FAMILIES = {
    "drivers": drivers, "grounds": grounds, "efforts": efforts, "bodies": bodies, "forces": forces,
    "couplings": couplings, "contacts": contacts, "commands": commands, "led": led,
}  # fmt: skip
