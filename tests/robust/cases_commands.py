"""Command lines that are mistakes: {(command, option): (what stands before, wrong values)}, and whole lines with their words."""

RUN = ("run", "rest", "--cells", "10", "--backend", "numpy")
PLANE = ("run", "vortex", "--model", "shallow-water", "--cells", "10", "--backend", "numpy")
COMPARE = ("compare", "rest", "--cells", "10", "--repeats", "1", "--backend", "numpy")
BENCH = ("bench", "--cells", "10", "--plane", "10", "--backends", "numpy", "--repeats", "1", "--orders", "1")
STRESS = ("stress", "toe", "--backends", "numpy", "--workers", "1")
ORDER = ("convergence", "simple-wave", "--cells", "10", "20", "--backend", "numpy")
SWEEP = ("sweep", "sweep.toml")

COUNTS = ("ten", "", "nan", "inf", "-1", "0", "1e3", "2.5", "0x10", "9" * 30, "1,5", "1j", "1e400", "9" * 5000)
TIMES = ("ten", "", "nan", "inf", "-inf", "-1", "0", "1e400", "1,5", "1j")
NUMBERS = ("ten", "", "nan", "inf", "1e400", "1,5")
NAMES = ("nonsense", "", "ROE", "7", " roe", "é", "roe,hll", "x" * 10_000)
FOLDERS = ("FILE", "FILE/below", "FILE/far/below", "/proc/nowhere/at/all", "x" * 300)
FILES = ("FOLDER", "FILE/below.toml", "nowhere.toml", "nonsense", "", "binary.toml", "latin.toml", "broken.toml", "FILE", "x" * 300 + ".toml")

OPTIONS = {
    ("run", "--cells"): (RUN, COUNTS), ("run", "--order"): (RUN, COUNTS), ("run", "--cfl"): (RUN, (*TIMES, "1.01", "2")),
    **{("run", name): (RUN, TIMES) for name in ("--dt", "--dt-max", "--dt-initial", "--stop-at-rest")},
    ("run", "--every"): ((*RUN, "--checkpoint", "new.npz"), ("ten", "", "nan", "inf", "-1", "1e400")),
    ("run", "--checkpoint"): (RUN, ("FOLDER", "new.nc", "new", "", "FILE/new.npz", "nowhere/new.npz", "FOLDER.npz")),
    ("run", "--resume"): (("run",), ("FOLDER", "FILE", "nowhere.npz", "FILE/old.npz", "broken.npz", "broken.toml", "solution.npz", "x" * 300)),
    **{("run", name): (RUN, NAMES) for name in ("--model", "--method", "--riemann", "--limiter", "--reconstruction", "--integrator", "--backend",
                                                "--plot", "--animate")},
    ("run", "--out"): (RUN, FOLDERS), ("run", "--rasters"): (RUN, ("png", "", ".asc")), ("run", "--netcdf"): (RUN, ()),
    ("run", "--gauges"): (RUN, ("ten", "", "nan", "1,2", "1,2,3", "1e9")), ("run", "--threshold"): (RUN, (*TIMES, "-0.1")),
    ("run", "--save"): (RUN, ("FOLDER", "FOLDER.npz", "new.txt", "new", "", "FILE/new.npz")), ("run", "--format"): (RUN, ("bmp", "", "PNG", ".png")),
    ("compare", "--format"): (COMPARE, ("bmp", "", "PNG")),
    ("check", "--model"): (("check", "rest"), NAMES), ("check", "--out"): (("check", "rest"), ("picture", "FOLDER", "")),
    ("run", "--line"): (PLANE, ("0", ("0", "0", "0.1"), ("0", "0", "9", "0"), ("ten", "0", "0", "0"), ("nan", "0", "0", "0"), ("0", "0", "0", "inf"),
                                ("0", "0", "0", "0"))),
    **{("compare", name): (COMPARE, COUNTS) for name in ("--cells", "--repeats", "--order")},
    ("compare", "--seconds"): (COMPARE, TIMES), ("compare", "--cfl"): (COMPARE, (*TIMES, "1.01")),
    **{("compare", name): (COMPARE, NAMES) for name in ("--models", "--method", "--riemann", "--limiter", "--reconstruction", "--integrator",
                                                        "--backend")},
    ("compare", "--plot-axes"): (COMPARE, ("steps", ("steps", "nonsense"), ("", "steps"), ("steps", "steps", "steps"))),
    ("compare", "--out"): (COMPARE, FOLDERS), ("compare", "--wide"): (COMPARE, ()),
    ("bench", "--cells"): (BENCH, (*COUNTS, "9")), ("bench", "--orders"): (BENCH, (*COUNTS, "3")), ("bench", "--repeats"): (BENCH, COUNTS),
    ("bench", "--plane"): (BENCH, (*COUNTS, "9")), ("bench", "--backends"): (BENCH, NAMES), ("bench", "--out"): (BENCH, FOLDERS),
    ("stress", "--workers"): (STRESS, COUNTS), ("stress", "--full"): (("stress",), ()),
    **{("stress", name): (STRESS, NAMES) for name in ("--scenes", "--backends")},
    ("stress", "--out"): (STRESS, FOLDERS),
    ("advise", "--tol"): (("advise", "rest"), (*TIMES, "1", "2")), ("advise", "--backend"): (("advise", "rest", "--check"), NAMES),
    ("advise", "--check"): (("advise",), ()),
    ("convergence", "--cells"): (ORDER, (*COUNTS, ("20", "10"), ("10", "10"), "10")), ("convergence", "--order"): (ORDER, COUNTS),
    ("convergence", "--cfl"): (ORDER, (*TIMES, "2")), ("convergence", "--expect"): (ORDER, NUMBERS),
    **{("convergence", name): (ORDER, NAMES) for name in ("--model", "--method", "--riemann", "--limiter", "--reconstruction", "--integrator",
                                                          "--backend", "--norm")},
    ("convergence", "--out"): (ORDER, FOLDERS),
    ("sweep", "--workers"): (SWEEP, COUNTS), ("sweep", "--dask"): (SWEEP, ("", "nonsense://nowhere")), ("sweep", "--out"): (SWEEP, FOLDERS),
    ("scenes", "--show"): (("scenes",), FILES), ("cache", "--clear"): (("cache",), ()),
}

#: Arguments that are no options.
PLACES = {**{(command, "SCENE"): ((command,), FILES) for command in ("run", "compare", "advise", "convergence", "stress", "check", "scenes")},
          ("sweep", "FILE"): (("sweep",), FILES)}

#: Whole lines, and words of the message.
LINES = [
    ((), ("COMMAND",)), (("fly",), ("fly",)), (("run",), ("SCENE", "--resume")), (("compare",), ("SCENE",)), (("sweep",), ("FILE",)),
    (("advise",), ("SCENE",)), (("check",), ("SCENE",)), (("check", "rest"), ("terrain", "fvkit advise")), (("run", "rest", "--resume", "old.npz"), ("SCENE", "--resume")),
    (("run", "rest", "--every", "3"), ("--every", "--checkpoint")), (("run", "--resume", "old.npz", "--dt", "1"), ("--dt", "--resume")),
    ((*RUN, "--dt", "1e-3", "--dt-max", "1"), ("`--dt`", "`--dt-max`")), ((*RUN, "--nonsense"), ("--nonsense",)), ((*RUN, "--cells"), ("--cells",)),
    ((*RUN, "surplus"), ("surplus",)), (("scenes", "surplus"), ("surplus",)), (("cache", "surplus"), ("surplus",)), (("cache", "--clear=1"), ("--clear",)),
    (("stress", "--full=1"), ("--full",)), (("advise", "rest", "--cells", "4"), ("--cells",)),
    (("compare", "rest", "--method", "wave-propagation", "--integrator", "dp5"), ("--integrator", "--method")),
    ((*RUN, "--cells", "1" + 15 * "0"), ("`--cells`", "GB", "1" + 15 * "0")), ((*COMPARE, "--cells", "1" + 15 * "0"), ("`--cells`", "GB")),
    (("run", "riemannn"), ("riemannn", "did you mean riemann?")), (("run", "rest", "--limiter", "mcc"), ("--limiter", "did you mean mc?")),
]
