"""Few combinations that cover every pair of settings."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import Any


def covering(every: Sequence[Mapping[str, Any]]) -> Iterator[Mapping[str, Any]]:
    """Greedily yield combinations until every pair of settings of two axes that occurs at all has occurred.

    Parameters
    ----------
    every : the possible combinations, {axis: setting}, settings hashable.
    """
    pairs = [frozenset(combinations(choice.items(), 2)) for choice in every]
    left = set().union(*pairs)
    while left:
        best = max(range(len(every)), key=lambda k: len(pairs[k] & left))
        left -= pairs[best]
        yield every[best]
