"""Files are written whole or not at all, under the name that was meant and no other."""

import csv
import io
import os
import re
import shutil
import stat
import sys
import tempfile
from contextlib import contextmanager
from pathlib import Path

# endings that promise a format
FORMATS = set(
    ".csv .tsv .txt .dat .xls .xlsx .ods .json .yaml .yml .toml .xml .html .htm .md .py .m .mat .npy .npz "
    ".h5 .hdf5 .parquet .feather .pickle .pkl .png .jpg .jpeg .gif .svg .pdf .eps .ps .tif .tiff .webp "
    ".fmu .ssp .ssd .zip .gz .bz2 .xz .7z .tar .urdf .step .stp .stl .asmt .c .h .so .dll .exe".split()
)

STANDARD_OUTPUT = "-"


@contextmanager
def replacing(path):
    """A temporary path, which takes the place of `path` when the block ends without an error.

    Folders are made as needed. On an error nothing is left behind and an old file stays as it was; an OSError
    names `path`. Of a symbolic link the target is replaced. What is no plain file (a pipe, a device), and
    `-`, the standard output, is written to.
    """
    path = Path(path)
    written = _is_written_to(path)
    target = path if written else Path(os.path.realpath(path))

    try:
        folder = None if written else target.parent
        if folder:
            folder.mkdir(parents=True, exist_ok=True)
        if target.is_file() and not written and not os.access(target, os.W_OK):
            raise PermissionError(13, os.strerror(13), str(path))
        handle, name = tempfile.mkstemp(prefix=f".{target.name}.", dir=folder)
    except OSError as error:
        raise _named(error, path) from error

    os.close(handle)
    temporary = Path(name)

    try:
        yield temporary

        if written:
            _pour(temporary, path)
        else:
            temporary.chmod(_mode(target))
            os.replace(temporary, target)
    except OSError as error:
        if error.filename not in (None, name):
            raise
        raise _named(error, path) from error
    finally:
        temporary.unlink(missing_ok=True)


def same(one, other) -> bool:
    """Whether two paths name one plain file, be it there or not yet."""
    if _is_written_to(Path(one)) or _is_written_to(Path(other)):
        return False

    if os.path.realpath(one) == os.path.realpath(other):
        return True

    return os.path.exists(one) and os.path.exists(other) and os.path.samefile(one, other)


def check_ending(path, what, *endings):
    """Raises ValueError when the path's ending promises a format other than those in `endings`; `what` is to
    be written.
    """
    ending = Path(path).suffix.lower()

    if ending in FORMATS - set(endings):
        raise ValueError(f"{path}: {what}, which is no {ending} file; let its name end in {endings[0]}")


def to_standard_output(path) -> bool:
    """Whether what is written there comes out of the standard output."""
    return _descriptor(Path(path)) == 1


def _descriptor(path):
    """The number of the open file that a path stands for, or None."""
    if str(path) == STANDARD_OUTPUT:
        return 1

    names = {"/dev/stdin": 0, "/dev/stdout": 1, "/dev/stderr": 2}
    found = re.fullmatch(r"/(?:dev|proc/self)/fd/(\d+)", path.as_posix())
    return int(found[1]) if found else names.get(path.as_posix())


def _is_written_to(path):
    """Whether a path is written to and never replaced: all that is no plain file."""
    if _descriptor(path) is not None:
        return True

    try:
        kind = os.stat(path).st_mode
    except OSError:
        return False

    return not (stat.S_ISREG(kind) or stat.S_ISDIR(kind))


def _pour(source, path):
    """What is in a file, into what is no plain file."""
    descriptor = _descriptor(path)

    if descriptor == 1:
        sys.stdout.flush()

    target = path if descriptor is None else os.dup(descriptor)

    with open(source, "rb") as file, open(target, "wb", buffering=0) as to:
        shutil.copyfileobj(file, to)


def _mode(target):
    """Permissions of a file that is there; of a new one those of the user's other files: mkstemp's are
    private.
    """
    if target.exists():
        return stat.S_IMODE(target.stat().st_mode)

    umask = os.umask(0)
    os.umask(umask)
    return 0o666 & ~umask


def _named(error, path):
    """The error as one of the file that the user named."""
    if error.errno is None:
        return type(error)(f"{path}: {error}")

    return type(error)(error.errno, error.strerror, str(path))


def csv_table(path):
    """(names, [(number of the line, cells)]) of a CSV file, a line of names first; blank ones do not count.

    Cells are parted by commas, or by semicolons where the first line is. Raises OSError, and ValueError that
    names the file: what is no text, what is empty, and a first line of numbers, which would be lost as names.
    """
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            text = file.read()

        first = next((line for line in text.splitlines() if line.strip()), "")
        reader = csv.reader(io.StringIO(text, newline=""), delimiter=";" if ";" in first else ",")
        lines = [(reader.line_num, cells) for cells in reader if any(cell.strip() for cell in cells)]
    except (UnicodeError, csv.Error) as error:
        raise ValueError(f"{path}: is no table of text: {error}") from None

    if not lines:
        raise ValueError(f"{path}: is empty; needs a line of names, then lines of numbers")

    (number, names), *rows = lines

    if _is_number(names[0]):
        raise ValueError(
            f"{path}: line {number} is of numbers, {first.strip()[:60]!r}, and would be lost: write a "
            "line of names above it"
        )

    return names, rows


def _is_number(text):
    try:
        float(text)
    except ValueError:
        return False
    return True


def save_table(path: str | os.PathLike, names, columns, digits="%.9g") -> None:
    """Columns of numbers, (n,) or (n, k) each, under a line of their names, as CSV, whole or not at all.

    digits : a format of C for all columns, or one for each.
    """
    import numpy as np

    with replacing(path) as temporary:
        rows, head = np.column_stack(columns), ",".join(names)
        np.savetxt(temporary, rows, fmt=digits, delimiter=",", header=head, comments="")


def save_figure(figure, path: str | os.PathLike, dpi: int = 110) -> None:
    """A figure of matplotlib in a file, whole or not at all: png, svg or pdf by its ending, else png."""
    kind = Path(path).suffix.lstrip(".").lower() or "png"

    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=dpi, format=kind)
