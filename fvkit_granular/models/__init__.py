"""Models of shallow granular flow: two-phase, reduced, shallow water, Pitman-Le, two-layer."""
