"""The picture of response amplitude operators: amplitudes and phases."""

from pathlib import Path

import numpy as np

from ..files import save_figure
from .rao import Rao

# of the largest amplitude of a unit: what is not drawn
SMALL = 1e-2


def draw_rao(path, found: Rao, title="") -> Path:
    """Amplitudes by unit, angles in degrees, and phases, over the period. path : png, svg or pdf."""
    from matplotlib.figure import Figure

    units = list(dict.fromkeys(found.units))
    figure = Figure(figsize=(11, 3.2 * (len(units) + 0.2)), layout="constrained")
    figure.suptitle(title, fontsize="medium")
    period = 2 * np.pi / found.omega

    for (size, phase), unit in zip(figure.subplots(len(units), 2, squeeze=False), units):
        own = [k for k, of in enumerate(found.units) if of == unit]
        largest = max(np.abs(found.answers[:, k]).max() for k in own)
        scale, told = (np.degrees(1.0), "deg") if unit == "rad" else (1.0, unit or "1")

        for k in own:
            answer = found.answers[:, k]

            if np.abs(answer).max() > SMALL * largest:
                size.plot(period, scale * np.abs(answer), linewidth=1.2, label=found.outputs[k])
                phase.plot(
                    period, np.degrees(np.unwrap(np.angle(answer))), linewidth=1.2, label=found.outputs[k]
                )

        size.set_title(f"amplitude, {told} per m", loc="left", fontsize="medium")
        phase.set_title("phase before the crest at the origin, deg", loc="left", fontsize="medium")
        size.legend(fontsize="small")

        for axes in (size, phase):
            axes.set_xlabel("period of the waves, s")
            axes.grid(alpha=0.3)

    save_figure(figure, path)
    return Path(path)
