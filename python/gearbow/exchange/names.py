"""Names of other programs as names of gearbow."""

import re
from collections.abc import Container


def cleaned(name: str) -> str:
    """Replace what names of gearbow do not contain: "/" and ":"."""
    return re.sub("[/:]", "-", name)


def unique(name: str, number: int, taken: Container[str]) -> str:
    """Clean a name, and add the number of its component if another part has it."""
    found = cleaned(name)
    return f"{found} [{number}]" if found in taken else found
