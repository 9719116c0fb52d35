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
        "fvkit/schemes/limiters.py": (f"{CORE}limiters.py", f"{CORE}stepping.py"),
        "fvkit/schemes/reconstruction.py": (f"{CORE}reconstruction.py", *_LINES),
    },
    "Riemann solvers": {
        "fvkit/schemes/riemann.py": (f"{CORE}user_model.py", *_SOLVERS),
        "fvkit_granular/models/relaxation.py": _SOLVERS,
    },
    "sources": {
        "fvkit/problem/sources.py": (f"{CORE}stepping.py", f"{CORE}contract.py", f"{GRANULAR}drag.py", f"{GRANULAR}friction.py"),
        "fvkit_granular/sources/drag.py": (f"{GRANULAR}drag.py", f"{GRANULAR}conformance.py", _NUMBERS),
        "fvkit_granular/sources/drag_laws.py": (f"{GRANULAR}drag.py", f"{GRANULAR}conformance.py", _NUMBERS),
        "fvkit_granular/sources/friction.py": (f"{GRANULAR}friction.py", f"{GRANULAR}conformance.py", _NUMBERS),
        "fvkit_granular/sources/friction_laws.py": (f"{GRANULAR}friction.py", f"{GRANULAR}conformance.py", _NUMBERS),
    },
    "models": {
        "fvkit/pointwise/functions.py": _STEPPING,
        "fvkit_granular/models/two_phase.py": _MODELS,
        "fvkit_granular/models/mixture.py": _MODELS,
        "fvkit_granular/models/two_masses.py": (*_MODELS, f"{GRANULAR}two_layer.py"),
        "fvkit_granular/models/wet_dry.py": _MODELS,
        "fvkit_granular/models/reduced.py": _MODELS,
        "fvkit_granular/models/shallow_water.py": _MODELS,
        "fvkit_granular/models/pitman_le.py": (f"{GRANULAR}pitman_le.py", f"{GRANULAR}conformance.py", _NUMBERS),
        "fvkit_granular/models/two_layer.py": (f"{GRANULAR}two_layer.py", f"{GRANULAR}conformance.py", _NUMBERS),
    },
    "schemes": {
        "fvkit/schemes/wave_propagation.py": _STEPPING,
        **{f"fvkit/schemes/stages/{name}.py": _STEPPING for name in ("fluctuations", "positivity", "dry_fallback", "faces")},
        **{f"fvkit/schemes/stages/{name}.py": _LINES for name in ("cell_polynomial", "shore_limiter")},
        "fvkit/schemes/stages/driven.py": (f"{GRANULAR}friction.py",),
        "fvkit/schemes/stages/in_cell_shocks.py": _IN_CELL,
        "fvkit/schemes/method_of_lines.py": _LINES,
        "fvkit/schemes/integrators.py": _LINES,
    },
    "kernel generator": {
        "fvkit/pointwise/tracing.py": _GENERATED,
        **{f"fvkit/backends/compiled/{name}.py": _GENERATED for name in ("llvm", "per_cell", "cell_updates", "generator", "loops")},
        "fvkit/backends/plan.py": _GENERATED,
        "fvkit/schemes/program.py": (*_LINES, *_GENERATED),
    },
}
