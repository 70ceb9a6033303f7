"""Systems of linear FMUs, masses on springs that push each other over links, and their exact solution."""

import numpy as np
from scipy.linalg import expm

import mbdfmi
from mbdfmi.cosim import System


def block():
    """A mass on a spring and a damper, with a force for an input; the scene."""
    return mbdfmi.Scene(
        name="block",
        gravity=[0, 0, 0],
        body={"block": {"mass": 1.0, "inertia": [1, 1, 1]}},
        joint={
            "rail": {
                "prismatic": {"axis": "x"},
                "between": ["ground", "block"],
                "spring": {"stiffness": 10.0},
                "damper": 0.5,
                "start": {"position": 0.1},
                "input": "force",
                "output": ["position", "speed", "acceleration"],
            }
        },
        solver={"tolerance": 1e-10},
    )


class Blocks:
    """n blocks whose forces are sums of others' positions, speeds and accelerations times factors, plus constants.

    position, speed, acceleration : matrices (n, n) of the factors, row: the block that is pushed; constant : (n,).
    """

    def __init__(self, file, mass, stiffness, damper, start, position, speed, acceleration, constant):
        self.file, self.mass, self.stiffness, self.damper, self.start = file, mass, stiffness, damper, start
        self.position, self.speed, self.acceleration, self.constant = position, speed, acceleration, constant
        self.names = [f"b{k}" for k in range(len(mass))]

    @classmethod
    def random(cls, file, seed, accelerations=False):
        """Of two to eight blocks; weakly enough linked to be stable."""
        rng = np.random.default_rng(seed)
        n = int(rng.integers(2, 9))
        stiffness = rng.uniform(5, 40, n)
        some = rng.random((n, n)) < 2.5 / n
        springs = np.where(some, rng.uniform(-1.0, 1.0, (n, n)), 0.0)
        dampers = np.where(rng.random((n, n)) < 1.5 / n, rng.uniform(-0.3, 0.3, (n, n)), 0.0)
        inertias = np.where(rng.random((n, n)) < 1.0 / n, rng.uniform(-0.3, 0.3, (n, n)), 0.0) * accelerations
        numbers = rng.uniform(0.5, 3.0, n), stiffness, rng.uniform(0.5, 3.0, n), rng.uniform(-0.2, 0.2, n)
        return cls(file, *numbers, springs, dampers, inertias, rng.uniform(-1, 1, n))

    def system(self, **master):
        """As a coupled system."""
        fmus = {
            name: {
                "file": str(self.file),
                "parameters": {
                    "block.mass": self.mass[k],
                    "rail.stiffness": self.stiffness[k],
                    "rail.damper": self.damper[k],
                    "rail.position_start": self.start[k],
                },
            }
            for k, name in enumerate(self.names)
        }
        links = []
        for k, name in enumerate(self.names):
            terms = [
                (f"{other}.rail.{quantity}", float(matrix[k, j]))
                for quantity, matrix in (
                    ("position", self.position),
                    ("speed", self.speed),
                    ("acceleration", self.acceleration),
                )
                for j, other in enumerate(self.names)
                if matrix[k, j]
            ]
            if terms:
                sources, factors = zip(*terms)
                links.append(
                    {
                        "source": list(sources),
                        "target": f"{name}.rail.force",
                        "factor": list(factors),
                        "offset": float(self.constant[k]),
                        "units": False,
                    }
                )
            else:
                fmus[name]["parameters"]["rail.force"] = float(self.constant[k])
        return System(fmu=fmus, link=links, master=master)

    def matrix(self):
        """A of x' = A x with x = (positions, speeds, 1), and the rows (n, 2n + 1) that make accelerations of x."""
        n = len(self.mass)
        M = np.diag(self.mass) - self.acceleration
        right = np.hstack(
            [
                self.position - np.diag(self.stiffness),
                self.speed - np.diag(self.damper),
                self.constant[:, None],
            ]
        )
        rows = np.linalg.solve(M, right)
        A = np.zeros((2 * n + 1, 2 * n + 1))
        A[:n, n : 2 * n] = np.eye(n)
        A[n : 2 * n] = rows
        return A, rows

    def exact(self, times):
        """(positions, speeds), [row, block], at equidistant times."""
        A, _ = self.matrix()
        n = len(self.mass)
        one = expm(A * (times[1] - times[0]))
        x = np.concatenate([self.start, np.zeros(n), [1.0]])
        rows = [x]
        for _ in times[1:]:
            rows.append(one @ rows[-1])
        rows = np.array(rows)
        return rows[:, :n], rows[:, n : 2 * n]

    def error(self, results):
        """The largest error of a position."""
        exact, _ = self.exact(results["time"])
        found = np.column_stack([results[f"{name}.rail.position"] for name in self.names])
        return np.abs(found - exact).max()
