"""Runs: time loop, observers, stop rules, checkpoints and failures."""
