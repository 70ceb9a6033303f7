"""CasADi reads our FMUs (model exchange): rates, Jacobians by directional derivatives, gradients by adjoint ones, its integrators."""

from pathlib import Path

import fmpy
import numpy as np
import pytest

from mbdfmi.compiler.model import compile_scene
from mbdfmi.export import export_fmu
from mbdfmi.scene import read_scene

casadi = pytest.importorskip("casadi", reason="NOT TESTED: casadi is not installed", exc_type=ImportError)

MODELS = Path(__file__).parents[1] / "models"


if tuple(map(int, casadi.__version__.split(".")[:2])) < (3, 7):
    pytest.skip(f"NOT TESTED: casadi {casadi.__version__} reads no FMI 3", allow_module_level=True)


def read(scene, fmi, folder):
    """CasADi's model and its function of rates by states and inputs, of a scene as an FMU."""
    model = compile_scene(read_scene(MODELS / f"{scene}.toml"))
    fmpy.extract(str(export_fmu(model, folder / "it.fmu", fmi=fmi)), str(folder / "it"))
    dae = casadi.DaeBuilder("it", str(folder / "it"))
    # of FMI 3 it takes no arrays, which some outputs are
    return dae, dae.create("f", ["x", "u"], ["ode", "y"] if fmi == 2 else ["ode"])


def start_of(dae):
    return np.ravel([dae.get(name) for name in dae.x()])


def flat(*parts):
    return np.concatenate([part.full().ravel() for part in parts])


def several(found):
    return found if isinstance(found, tuple | list) else [found]


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("scene", ["two_link_arm", "four_bar"])
def test_derivatives(scene, fmi, tmp_path):
    """Its Jacobian is the limit of differences of its own values; gradients (adjoint in FMI 3) are rows of it."""
    dae, f = read(scene, fmi, tmp_path)
    n, m, unknowns = dae.nx(), dae.nu(), range(f.n_out())
    dice = np.random.default_rng(1)
    # a loop is left where it is closed
    x = start_of(dae) if scene == "four_bar" else dice.normal(size=n)
    u = dice.normal(size=m)
    nothing = [casadi.DM(f.size1_out(k), 1) for k in unknowns]
    blocks = iter(several(f.jacobian()(x, u, *nothing)))
    J = np.vstack([np.hstack([next(blocks).full(), next(blocks).full()]) for _ in unknowns])

    def values(z):
        return flat(*several(f(z[:n], z[n:])))

    z, h = np.concatenate([x, u]), 1e-3
    for k in range(n + m):
        e = h * np.eye(n + m)[k]
        shown = (8 * (values(z + e) - values(z - e)) - (values(z + 2 * e) - values(z - 2 * e))) / (12 * h)
        np.testing.assert_allclose(J[:, k], shown, rtol=1e-6, atol=1e-7 * np.abs(J).max())

    weights = [dice.normal(size=f.size1_out(k)) for k in unknowns]
    found = flat(*f.reverse(1)(x, u, *nothing, *weights))
    np.testing.assert_allclose(found, np.concatenate(weights) @ J, rtol=1e-9, atol=1e-9 * np.abs(J).max())


def test_its_integrator(tmp_path):
    """CVODES of CasADi finds what the co-simulation does, and how the end depends on a held torque."""
    dae, f = read("two_link_arm", 3, tmp_path)
    x, u = casadi.MX.sym("x", dae.nx()), casadi.MX.sym("u", dae.nu())
    options = {"reltol": 1e-10, "abstol": 1e-10}
    march = casadi.integrator("I", "cvodes", {"x": x, "p": u, "ode": f(x, u)}, 0, 0.5, options)

    def end(torque):
        run = fmpy.simulate_fmu(
            str(tmp_path / "it.fmu"),
            stop_time=0.5,
            output_interval=0.01,
            input=np.array([(0.0, torque)], dtype=[("time", float), ("shoulder.torque", float)]),
        )
        return [run[name][-1] for name in ("shoulder.angle", "elbow.angle", "shoulder.speed", "elbow.speed")]

    found = march(x0=start_of(dae), p=[1.0, 0.0])["xf"].full().ravel()
    np.testing.assert_allclose(found, end(1.0), atol=1e-6)

    p = casadi.MX.sym("p", dae.nu())
    slope = casadi.Function("s", [p], [casadi.jacobian(march(x0=start_of(dae), p=p)["xf"], p)])
    shown = (np.array(end(1.1)) - end(0.9)) / 0.2
    np.testing.assert_allclose(slope([1.0, 0.0]).full()[:, 0], shown, rtol=2e-3, atol=2e-3)
