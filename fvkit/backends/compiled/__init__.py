"""Compiled backend: pointwise code traced, generated as LLVM and compiled by numba."""
