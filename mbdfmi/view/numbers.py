"""Numbers of a page, as its viewer/numbers.js reads them."""

import base64

import numpy as np


def packed(values):
    """Numbers as 16-bit steps of their range: as fine as a plot or an arrow can show."""
    values = np.asarray(values, float)
    low, high = float(values.min()), float(values.max())
    scale = (high - low) / 65000 or 1.0
    offset = (low + high) / 2
    whole = np.round((values - offset) / scale).astype("<i2")
    return {"data": base64.b64encode(whole.tobytes()).decode(), "scale": scale, "offset": offset}


def exact(values):
    """Numbers as floats of 32 bits."""
    return {"data": base64.b64encode(np.asarray(values, "<f4").tobytes()).decode()}
