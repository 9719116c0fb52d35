"""Units and meanings of what the models of this package call by name, after the CF conventions."""

QUANTITIES = {
    "h": ("m", "depth of the flow"),
    "hs": ("m", "depth of the solid"),
    "hf": ("m", "depth of the fluid"),
    "hs vs": ("m2 s-1", "discharge of the solid"),
    "hf vf": ("m2 s-1", "discharge of the fluid"),
    "h v": ("m2 s-1", "discharge"),
    "rho h": ("m", "mass per area over the density of the solid"),
    "rho h v": ("m2 s-1", "momentum per area over the density of the solid"),
    "phi": ("1", "volume fraction of the solid"),
    "vs": ("m s-1", "velocity of the solid"),
    "vf": ("m s-1", "velocity of the fluid"),
    "v": ("m s-1", "velocity of the mixture"),
    "surface": ("m", "height of the free surface"),
    "b": ("m", "height of the bottom"),
}

#: The same where the two masses are layers, the first below.
LAYERS = QUANTITIES | {
    "hs": ("m", "depth of the lower layer"),
    "hf": ("m", "depth of the upper layer"),
    "hs vs": ("m2 s-1", "discharge of the lower layer"),
    "hf vf": ("m2 s-1", "discharge of the upper layer"),
    "phi": ("1", "share of the lower layer in the depth"),
    "vs": ("m s-1", "velocity of the lower layer"),
    "vf": ("m s-1", "velocity of the upper layer"),
    "interface": ("m", "height of the interface between the layers"),
}
