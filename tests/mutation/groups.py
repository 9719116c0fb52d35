"""The numerical core in groups, and the test files that look at each module: short ones, on the NumPy backend where a mutant shows there."""

CORE, GRANULAR = "tests/core/test_", "tests/granular/test_"

_NUMBERS = f"{GRANULAR}fingerprints.py"
_STEPPING = (f"{CORE}stepping.py", f"{CORE}riemann.py", f"{CORE}teaching_models.py", f"{GRANULAR}two_phase.py", f"{GRANULAR}reduced_shallow.py",
             f"{GRANULAR}dry.py", f"{GRANULAR}background.py", _NUMBERS)
_SOLVERS = (f"{CORE}riemann.py", f"{CORE}teaching_models.py", f"{CORE}conformance.py", f"{GRANULAR}two_phase.py", f"{GRANULAR}reduced_shallow.py",
            f"{GRANULAR}conformance.py", _NUMBERS)
_MODELS = (f"{GRANULAR}two_phase.py", f"{GRANULAR}reduced_shallow.py", f"{GRANULAR}conformance.py", _NUMBERS)
_GENERATED = tuple(f"tests/backends/test_{name}.py" for name in ("trace", "kernels", "runs", "fingerprints", "positions"))
_IN_CELL = (f"{GRANULAR}in_cell_shocks.py", *_STEPPING)
_LINES = (f"{CORE}method_of_lines.py", f"{GRANULAR}method_of_lines.py", f"{GRANULAR}background.py", _NUMBERS)

#: group -> module -> test files.
GROUPS: dict[str, dict[str, tuple[str, ...]]] = {
    "limiters": {
        "fvkit/limiters.py": (f"{CORE}limiters.py", f"{CORE}stepping.py"),
        "fvkit/reconstruction.py": (f"{CORE}reconstruction.py", *_LINES),
    },
    "Riemann solvers": {
        "fvkit/riemann/base.py": (f"{CORE}user_model.py", *_SOLVERS),
        "fvkit/riemann/hll.py": _SOLVERS,
        "fvkit/riemann/viscous.py": _SOLVERS,
        "fvkit/riemann/pyclaw.py": _SOLVERS,
        "fvkit/riemann/roe.py": _SOLVERS,
        "fvkit/riemann/rusanov.py": _SOLVERS,
        "fvkit_granular/relaxation.py": _SOLVERS,
    },
    "sources": {
        "fvkit/sources.py": (f"{CORE}stepping.py", f"{CORE}contract.py", f"{GRANULAR}drag.py", f"{GRANULAR}friction.py"),
        "fvkit_granular/drag.py": (f"{GRANULAR}drag.py", f"{GRANULAR}conformance.py", _NUMBERS),
        "fvkit_granular/friction.py": (f"{GRANULAR}friction.py", f"{GRANULAR}conformance.py", _NUMBERS),
    },
    "models": {
        "fvkit/pointwise.py": _STEPPING,
        "fvkit_granular/two_phase.py": _MODELS,
        "fvkit_granular/two_masses.py": (*_MODELS, f"{GRANULAR}two_layer.py"),
        "fvkit_granular/bed.py": _MODELS,
        "fvkit_granular/reduced.py": _MODELS,
        "fvkit_granular/shallow_water.py": _MODELS,
        "fvkit_granular/pitman_le.py": (f"{GRANULAR}pitman_le.py", f"{GRANULAR}conformance.py", _NUMBERS),
        "fvkit_granular/two_layer.py": (f"{GRANULAR}two_layer.py", f"{GRANULAR}conformance.py", _NUMBERS),
    },
    "schemes": {
        **{f"fvkit/schemes/{name}.py": _STEPPING for name in ("fluctuations", "dry", "wave_propagation", "faces")},
        **{f"fvkit/schemes/{name}.py": _LINES for name in ("cells", "shores")},
        "fvkit/schemes/driven.py": (f"{GRANULAR}friction.py",),
        "fvkit/schemes/in_cell.py": _IN_CELL,
        "fvkit/schemes/method_of_lines.py": _LINES,
        "fvkit/integrators.py": _LINES,
    },
    "kernel generator": {
        **{f"fvkit/backends/{name}.py": _GENERATED for name in ("trace", "emit", "percell", "halo", "ends", "generator", "writer")},
        "fvkit/backends/program.py": (*_LINES, *_GENERATED),
    },
}
