"""What m and d are in compiled code: the addresses of their buffers, in their order.

An array is a bare pointer, found when it is used from an offset in the header that the compiler may take for
constant. (A NamedTuple of 200 numpy arrays was tried: 7 machine words an array, 25 s to compile four
tiny kernels.)
"""

import llvmlite.ir as ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    NativeValue,
    infer_getattr,
    lower_getattr_generic,
    models,
    register_model,
    typeof_impl,
    unbox,
)

from .compiling import TYPES, load_apart
from .layout import COUNTS, ARRAY, SLOT
from .views import DataView, ModelView, _View

INTS = types.CPointer(types.int64)
REALS = TYPES["REALS"]


class _ViewType(types.Type):
    def __init__(self, view):
        self.view = view
        super().__init__(name=view.__name__)


_TYPES = {view: _ViewType(view) for view in (ModelView, DataView)}
TYPES |= {"MODEL": _TYPES[ModelView], "DATA": _TYPES[DataView]}


@typeof_impl.register(_View)
def _typeof_view(value, context):
    load_apart()
    return _TYPES[type(value)]


@register_model(_ViewType)
class _ViewData(models.StructModel):
    def __init__(self, dmm, fe_type):
        members = [(name, INTS if name == "ints" else REALS) for name in fe_type.view.buffer_names]
        super().__init__(dmm, fe_type, members)


@unbox(_ViewType)
def _unbox_view(typ, obj, c):
    struct = cgutils.create_struct_proxy(typ)(c.context, c.builder)

    for name in typ.view.buffer_names:
        address = c.pyapi.object_getattr_string(obj, f"{name}_address")
        value = c.pyapi.long_as_ulonglong(address)
        c.pyapi.decref(address)
        pointer = getattr(struct, name).type
        setattr(struct, name, c.builder.inttoptr(value, pointer))

    return NativeValue(struct._getvalue(), is_error=cgutils.is_not_null(c.builder, c.pyapi.err_occurred()))


@infer_getattr
class _ViewAttribute(AttributeTemplate):
    key = _ViewType

    def generic_resolve(self, typ, name):
        if name in COUNTS:
            return types.int64

        if name == "u_buffer" and "u" in typ.view.buffer_names:
            return REALS

        if name in ARRAY and ARRAY[name].buffer in typ.view.buffer_names:
            return INTS if ARRAY[name].buffer == "ints" else REALS


@lower_getattr_generic(_ViewType)
def _view_attribute(context, builder, typ, value, name):
    struct = cgutils.create_struct_proxy(typ)(context, builder, value=value)

    def header(slot):
        load = builder.load(builder.gep(struct.ints, [ir.Constant(ir.IntType(64), slot)]))
        load.set_metadata("invariant.load", builder.module.add_metadata([]))
        return load

    if name == "u_buffer":
        return struct.u

    if name in COUNTS:
        return header(COUNTS.index(name))

    return builder.gep(getattr(struct, ARRAY[name].buffer), [header(SLOT[name])])
