"""Signatures of kernels that are called by a symbol: kinds of results and arguments, by name.

What they are in compiled code is said in `compiling`, what they are to Python in `native.library`.
"""


class Kind:
    """A kind of number, or what m and d are; called with kinds of arguments it makes a signature.

    members : of a tuple.
    """

    def __init__(self, name: str, members: tuple = ()):
        self.name = name
        self.members = members

    def __call__(self, *args):
        return Signature(self, args)

    def __repr__(self):
        return self.name


class Signature:
    """What a kernel returns, and takes."""

    def __init__(self, return_type: Kind, args: tuple):
        self.return_type = return_type
        self.args = args


def Tuple(members):
    """The kind of a tuple."""
    return Kind("Tuple", tuple(members))


boolean = Kind("boolean")
int64 = Kind("int64")
float64 = Kind("float64")
void = Kind("void")
REALS = Kind("REALS")  # an array of float64
MODEL = Kind("MODEL")  # m
DATA = Kind("DATA")  # d
