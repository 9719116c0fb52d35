"""Pairwise covering: a small set of combinations that contains every pair of settings."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import Any


def covering(every: Sequence[Mapping[str, Any]]) -> Iterator[Mapping[str, Any]]:
    """Yield a greedy pairwise covering of all possible combinations {axis: setting}: some that contain every possible pair of
    settings of two axes. Settings are hashable.
    """
    pairs = [frozenset(combinations(choice.items(), 2)) for choice in every]
    left = set().union(*pairs)
    while left:
        best = max(range(len(every)), key=lambda k: len(pairs[k] & left))
        left -= pairs[best]
        yield every[best]
