"""Interpreted kernels, in a process of their own: it takes (scene, plan, way) and gives a `Run`,
one after the other."""

import os
import pickle
import subprocess
import sys

import numpy as np

from .ways import Run, run

TERMINATES = 5.0  # s that the process has to end


class Interpreter:
    """Runs ways with kernels as plain Python; the process starts with the first one. Use it in a `with`."""

    def __init__(self):
        self._process = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self._process:
            self._process.stdin.close()

            try:
                self._process.wait(TERMINATES)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()

    def run(self, data, plan, way):
        """As `ways.run`."""
        if self._process is None:
            paths = {
                "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
                "PYTHONSAFEPATH": "1",
                "MBDFMI_INTERPRETED": "1",
            }
            command = [sys.executable, "-m", f"{__package__}.interpreter"]
            self._process = subprocess.Popen(
                command, env=os.environ | paths, stdin=subprocess.PIPE, stdout=subprocess.PIPE
            )

        pickle.dump((data, plan, way), self._process.stdin)
        self._process.stdin.flush()

        try:
            return pickle.load(self._process.stdout)
        except EOFError:
            status = self._process.wait()
            self._process = None
            return Run(way, crashed=f"the process of interpreted kernels ended with {status}")


def serve():
    """Answer until the input ends. What is printed goes to the error stream."""
    np.seterr(all="ignore")  # as compiled kernels do
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)

    while True:
        try:
            question = pickle.load(sys.stdin.buffer)
        except EOFError:
            return

        pickle.dump(run(*question), answers)
        answers.flush()


if __name__ == "__main__":
    serve()
