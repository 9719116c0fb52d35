"""Models of granular flow: two phases, two layers, the reduced model, shallow water."""
