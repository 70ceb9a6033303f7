"""Other libraries' forward dynamics of the same mechanisms, each at its best.

A peer is made of links and has `name`, `how` (it is measured), `largest` (number of links that it can
take), `preparing` (what may take a while before), `run(n)` to evaluate the accelerations n times,
`overhead(n)`, what to take off for calling it n times (or None), and `accelerations()` (rad/s2) by link.
"""

import ctypes
import importlib
import sys
from functools import cache
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from .mechanisms import GRAVITY, Link
from .native import Missing, compiled


def library_of(module: str, package: str):
    """An optional library. Raises Missing."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise Missing(f"no {module} here (pip install {package}): {error}") from None


def _columns(links):
    """Angles (rad), speeds (rad/s) and torques (N m) of the joints."""
    rows = [(link.angle, link.speed, link.torque) for link in links]
    return np.array(rows).reshape(-1, 3).T.copy()


def peers_here(candidates, tell) -> tuple[list[type], dict[str, str], dict[str, str]]:
    """Of classes of peers those that can run here, their versions, and why the others cannot, by name.

    tell : called with what may take a while.
    """
    peers, versions, missing = [], {}, {}

    for peer in candidates:
        tell(peer.preparing)

        try:
            versions[peer.name] = peer.version()
            peers.append(peer)
        except Missing as why:
            missing[peer.name] = str(why)

    return peers, versions, missing


class Pinocchio:
    """Pinocchio's `aba` as in the wheel `pin`, called from Python."""

    name = "Pinocchio"
    largest = 256  # joints; its Data holds tensors of their third power: of 1024, 34 GB
    preparing = "loading Pinocchio"
    how = "pin's wheel, called from Python; the same call on a mechanism without joints taken off"

    @classmethod
    def version(cls) -> str:
        """Version of the library. Raises Missing."""
        return library_of("pinocchio", "pin").__version__

    def __init__(self, links: list[Link]):
        pin = self.pin = library_of("pinocchio", "pin")
        self.model = pin.Model()
        self.model.gravity.linear = np.array(GRAVITY)
        joints = (pin.JointModelRX, pin.JointModelRY, pin.JointModelRZ)

        for i, link in enumerate(links):
            placement = pin.SE3(link.rotation, link.position)
            kind = joints[link.axis]()
            joint = self.model.addJoint(link.parent + 1, kind, placement, f"joint{i}")
            body = pin.Inertia(link.mass, link.com, link.inertia)
            self.model.appendBodyToJoint(joint, body, pin.SE3.Identity())

        self.arguments = self._arguments(self.model, links)
        self.empty = self._arguments(pin.Model(), [])

    def _arguments(self, model, links):
        return (model, model.createData(), *_columns(links), self.pin.Convention.WORLD)

    def run(self, n):
        """Evaluate n times."""
        aba, arguments = self.pin.aba, self.arguments

        for _ in range(n):
            aba(*arguments)

    def overhead(self, n):
        """Call it n times with nothing to do."""
        aba, arguments = self.pin.aba, self.empty

        for _ in range(n):
            aba(*arguments)

    def accelerations(self):
        """rad/s2 by link."""
        return self.pin.aba(*self.arguments).copy()


class PinocchioNative:
    """Pinocchio's headers compiled for this processor, in a loop in C++."""

    name = "Pinocchio (C++)"
    largest = Pinocchio.largest
    preparing = "compiling Pinocchio's headers (minutes, once)"
    how = "its headers compiled for this processor by zig's clang, -O3 -march=native; a loop in C++"
    overhead = None

    @classmethod
    def version(cls) -> str:
        """Version of the library. Raises Missing."""
        cls._library()
        return Pinocchio.version()

    @classmethod
    @cache
    def _library(cls):
        Pinocchio.version()
        library = compiled_with_pinocchio("pinocchio_loop.cpp")
        reals = np.ctypeslib.ndpointer(np.float64, flags="C")
        handle = ctypes.c_void_p
        library.mechanism_new.restype = handle
        library.mechanism_delete.argtypes = [handle]
        library.mechanism_add.argtypes = [
            handle,
            ctypes.c_int,
            ctypes.c_int,
            reals,
            reals,
            ctypes.c_double,
            reals,
            reals,
        ]
        library.mechanism_set.argtypes = [handle, reals, reals, reals, reals]
        library.mechanism_loop.argtypes = [handle, ctypes.c_long]
        library.mechanism_accelerations.argtypes = [handle, reals]
        return library

    def __init__(self, links: list[Link]):
        self.library = self._library()
        self.handle = self.library.mechanism_new()
        self.n = len(links)

        for link in links:
            place = (link.position, link.rotation.T.copy())
            body = (link.mass, link.com, link.inertia)
            self.library.mechanism_add(self.handle, link.parent, link.axis, *place, *body)

        self.library.mechanism_set(self.handle, np.array(GRAVITY), *_columns(links))

    def __del__(self):
        if hasattr(self, "handle"):
            self.library.mechanism_delete(self.handle)

    def run(self, n):
        """Evaluate n times."""
        self.library.mechanism_loop(self.handle, n)

    def accelerations(self):
        """rad/s2 by link."""
        vdot = np.zeros(self.n)
        self.run(1)
        self.library.mechanism_accelerations(self.handle, vdot)
        return vdot


def _include_folders():
    """Where the headers of Pinocchio, Boost and Eigen are."""
    prefixes = [Path(path) / "cmeel.prefix" for path in sys.path]
    prefixes += [Path(sys.prefix), Path("/usr"), Path("/usr/local")]
    folders = []

    for header, below in (
        ("pinocchio/algorithm/aba.hpp", "include"),
        ("boost/variant.hpp", "include"),
        ("Eigen/Core", "include/eigen3"),
    ):
        found = [prefix / below for prefix in prefixes if (prefix / below / header).is_file()]

        if not found:
            raise Missing(f"no header {header} here (pip install pin cmeel-eigen)")

        folders.append(found[0])

    return folders


def compiled_with_pinocchio(name: str) -> ctypes.CDLL:
    """A source beside this file that needs Pinocchio's headers, as a library. Raises Missing."""
    folders = list(dict.fromkeys(_include_folders()))
    return compiled(name, folders=folders, versions=(Pinocchio.version(),))


class MuJoCo:
    """MuJoCo's smooth dynamics: what `mj_forward` calls for a mechanism without contacts."""

    name = "MuJoCo"
    largest = 512  # a chain of 1024 is too deep for it
    preparing = "loading MuJoCo"
    how = (
        "mj_kinematics, mj_comPos, mj_makeM, mj_factorM, mj_comVel, mj_rne, mj_solveM of its "
        "C library; a compiled loop"
    )
    overhead = None

    @classmethod
    def version(cls) -> str:
        """Version of the library. Raises Missing."""
        _mujoco_loop()
        return library_of("mujoco", "mujoco").__version__

    def __init__(self, links: list[Link]):
        mujoco = library_of("mujoco", "mujoco")
        spec = mujoco.MjSpec()
        spec.option.gravity = GRAVITY
        bodies = []

        for i, link in enumerate(links):
            parent = bodies[link.parent] if link.parent >= 0 else spec.worldbody
            I = link.inertia
            bodies.append(
                parent.add_body(
                    pos=link.position,
                    quat=np.roll(Rotation.from_matrix(link.rotation).as_quat(), 1),
                    mass=link.mass,
                    ipos=link.com,
                    fullinertia=[I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]],
                    explicitinertial=True,
                )
            )
            joint = bodies[i].add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, name=f"joint{i}")
            joint.axis = np.eye(3)[link.axis]

        self.model = spec.compile()
        self.data = data = mujoco.MjData(self.model)
        self.order = [self.model.joint(f"joint{i}").dofadr[0] for i in range(len(links))]
        data.qpos[self.order] = [link.angle for link in links]
        data.qvel[self.order] = [link.speed for link in links]
        data.qfrc_applied[self.order] = [link.torque for link in links]
        self.loop = _mujoco_loop()

    def run(self, n):
        """Evaluate n times."""
        d = self.data
        addresses = (self.model._address, d._address, d.qfrc_bias.ctypes.data, d.qacc.ctypes.data)
        self.loop(*addresses, d.qfrc_applied, d.qfrc_bias, d.qacc, n)

    def accelerations(self):
        """rad/s2 by link."""
        self.run(1)
        return self.data.qacc[self.order]


@cache
def _mujoco_loop():
    """n evaluations through the C library's functions, without Python in between."""
    import numba

    folder = Path(library_of("mujoco", "mujoco").__file__).parent
    names = ("libmujoco*.so*", "libmujoco*.dylib", "mujoco.dll")
    libraries = [path for name in names for path in folder.glob(name)]

    if not libraries:
        raise Missing(f"no library of MuJoCo in {folder}")

    library = ctypes.CDLL(str(libraries[0]))
    pointer = ctypes.c_void_p

    def function(name, *more):
        try:
            found = getattr(library, name)
        except AttributeError:
            raise Missing(f"this MuJoCo has no {name} (pip install --upgrade mujoco)") from None

        found.argtypes = [pointer, pointer, *more]
        found.restype = None
        return found

    kinematics = function("mj_kinematics")
    com_pos = function("mj_comPos")
    make_M = function("mj_makeM")
    factor_M = function("mj_factorM")
    com_vel = function("mj_comVel")
    rne = function("mj_rne", ctypes.c_int, pointer)
    solve_M = function("mj_solveM", pointer, pointer, ctypes.c_int)

    @numba.njit(error_model="numpy")
    def loop(m, d, bias_address, acceleration_address, applied, bias, acceleration, n):
        for _ in range(n):
            kinematics(m, d)
            com_pos(m, d)
            make_M(m, d)
            factor_M(m, d)
            com_vel(m, d)
            rne(m, d, 0, bias_address)

            for k in range(len(bias)):
                acceleration[k] = applied[k] - bias[k]

            solve_M(m, d, acceleration_address, acceleration_address, 1)

    return loop
