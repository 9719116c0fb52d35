"""Memory: what cannot fit is refused in a sentence, before anything is allocated."""

import os


def physical() -> float:
    """Return the memory of this machine, bytes; infinite where the system does not tell."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, ValueError, OSError):  # not on every system
        return float("inf")


def check(count: int, floats: int, name: str) -> None:
    """Raise ValueError where ``count`` items of so many floats, which the argument ``name`` asks for, exceed the memory."""
    needed, there = 8.0 * floats * count, physical()
    if needed > there:
        raise ValueError(f"`{name}` must fit into memory: {count} need about {needed / 1e9:.3g} GB, this machine has "
                         f"{there / 1e9:.3g} GB")
