"""Studies of scenes: comparisons, benchmarks, advice on the model."""
