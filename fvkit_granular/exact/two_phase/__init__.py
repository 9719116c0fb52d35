"""Riemann problem of the two-phase model: rarefactions, shock loci, wave curves, and paths across shocks."""
