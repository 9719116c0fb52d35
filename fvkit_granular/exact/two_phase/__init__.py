"""Riemann problem of the two-phase model: its waves, and what it depends on inside its shocks."""
