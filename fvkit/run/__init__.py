"""Runs: the time loop, its observers, stops, checkpoints and failures."""
