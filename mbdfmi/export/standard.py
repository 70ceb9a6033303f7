"""Files of the FMI standard, which fmpy carries; importing it takes longer than an export."""

from functools import cache
from importlib.util import find_spec
from pathlib import Path

from lxml import etree


def folder() -> Path:
    """fmpy's own: headers in c-code, schemas in schema/fmi2, ..."""
    found = find_spec("fmpy")

    if found is None or found.origin is None:
        raise ImportError("fmpy is not installed: pip install fmpy")

    return Path(found.origin).parent


@cache
def schema(fmi: int, name: str) -> etree.XMLSchema:
    """A schema of a version of FMI."""
    return etree.XMLSchema(file=str(folder() / "schema" / f"fmi{fmi}" / f"{name}.xsd"))
