"""Many communication steps in one compiled loop, for those who measure."""

from ..kernels import entry
from ..kernels.language import kernel
from ..kernels.status import OK


@kernel
def follow(m, d, times, y, rows):
    """Outputs, rows (n_t, n_y), at the times (n_t,), s, by one communication step to each. Returns a status.

    y : (n_y,) to work in.
    """
    for k in range(len(times)):
        failure = entry.step(m, d, times[k] - d.time[0])

        if failure != OK:
            return failure

        failure = entry.compute_outputs(m, d, y)

        if failure != OK:
            return failure

        for j in range(len(y)):
            rows[k, j] = y[j]

    return OK
