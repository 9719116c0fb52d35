"""Schemes: how a problem is solved, and the parts they are made of: Riemann solvers, limiters, integrators."""
