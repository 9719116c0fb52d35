"""Problem: what is solved, with no word about how: model, grid, initial state, boundaries, sources."""
