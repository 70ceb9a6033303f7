"""`m` and `d`, through which kernels read and write the buffers of a model.

`m` (ModelView) names the arrays of `ints` and `reals`, which a kernel only reads; `d` (DataView) those of
`state`, `work` and the inputs `u`. `m.body_parent`, `d.x` are the arrays of the layout table, `m.n_body` its counts.

In Python a view gives numpy arrays. In compiled code (see `compiled_views`) it is nothing but the buffers' addresses.
"""

import numpy as np

from .layout import COUNTS, ARRAY, SLOT, array_length


class _View:
    """The arrays of some buffers by name."""

    buffer_names: tuple[str, ...] = ()
    addresses_name = ""  # of the tuple of the buffers' addresses, which native code takes

    def __init__(self, **buffers):
        for name in self.buffer_names:
            array = buffers[name]
            dtype = np.int64 if name == "ints" else np.float64
            assert array.dtype == dtype and array.flags.c_contiguous and array.ndim == 1, name
            setattr(self, f"{name}_buffer", array)
            setattr(self, f"{name}_address", array.ctypes.data)

        setattr(
            self, self.addresses_name, tuple(getattr(self, f"{name}_address") for name in self.buffer_names)
        )

        ints = self.ints_buffer
        counts = {name: int(ints[k]) for k, name in enumerate(COUNTS)}
        self.__dict__.update(counts)

        for name, array in ARRAY.items():
            if array.buffer in self.buffer_names:
                offset = ints[SLOT[name]]
                buffer = getattr(self, f"{array.buffer}_buffer")
                setattr(self, name, buffer[offset : offset + array_length(array, counts)])


class ModelView(_View):
    """`m`: structure and parameters. Buffers: ints (int64) and reals (float64), one-dimensional."""

    buffer_names = ("ints", "reals")
    addresses_name = "model_addresses"


class DataView(_View):
    """`d`: state, work and inputs. Buffers: ints (int64); state, work, u (float64), one-dimensional.

    `u_buffer` holds the inputs' values, then their derivatives of order 1 to 5, n_u each.
    """

    buffer_names = ("ints", "state", "work", "u")
    addresses_name = "data_addresses"
