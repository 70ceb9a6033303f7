"""Mutants that no test can or need tell, each with the reason: (file, line before, line after, why)."""

EQUIVALENT = [
]


def argument(mutant):
    """Why a mutant changes nothing that could be told, or None."""
    for file, before, after, why in EQUIVALENT:
        if (file, before, after) == (mutant.file, mutant.before, mutant.after):
            return why

    return None
