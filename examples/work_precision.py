"""Work against precision
======================

Every scheme on five scenes, and the orders of two of them on the smooth ones.

Where the flow is smooth, order buys accuracy: the fifth-order method of lines is the fastest from some error on. Where it
jumps or has kinks, the error falls with the first power of the cells whatever the order, and cheap steps win.

Usage: python examples/work_precision.py [FOLDER] [--cells N ...] [--repeats R] [--backend B]
(writes work_precision.png into FOLDER, default: the current one; the defaults are small, for a quick look)
"""

# sphinx_gallery_thumbnail_path = "images/work_precision.png"
import argparse
from functools import partial
from pathlib import Path

import fvkit as fv
import fvkit_granular as gr
from fvkit.output.figures import new_axes, plot_series, style

NAMES = ("simple-wave", "slip-over-bottom", "riemann", "dam-break-phi", "perturbed-rest")
ROE = fv.Roe()
SCHEMES = {
    "waves, order 1": fv.WavePropagation(ROE, order=1),
    "waves, MC": fv.WavePropagation(ROE),
    "waves, MC, in-cell": fv.WavePropagation(ROE, in_cell_shocks=True),
    "lines, MUSCL, SSPRK3": fv.MethodOfLines(ROE, fv.MUSCL(), fv.SSPRK3()),
    "lines, WENO5, SSPRK104": fv.MethodOfLines(ROE, fv.WENO5()),
    "lines, MP5, SSPRK3": fv.MethodOfLines(ROE, fv.MP5(), fv.SSPRK3()),
    "lines, MP5, SSPRK104": fv.MethodOfLines(ROE),
    "lines, MP5, DP5": fv.MethodOfLines(ROE, fv.MP5(), fv.DP5()),
}


def orders(cells: list[int], backend: str) -> None:
    """Print errors and observed orders where the flow is smooth."""
    for name in NAMES[:2]:
        scene = gr.scene(name)
        for label in ("waves, MC", "lines, MP5, SSPRK104", "lines, MP5, DP5"):
            found = fv.convergence(partial(scene.problem, gr.TwoPhase), SCHEMES[label], cells, scene.known_reference(),
                                   backend=backend)
            print(f"{name}: {found}\n")


def main(folder: Path, cells: list[int], repeats: int, backend: str) -> None:
    orders(cells, backend)
    figure, axes = new_axes(2, 3, width=3.9, height=3.1)
    for name, ax in zip(NAMES, axes, strict=False):
        report = gr.compare(gr.scene(name), [gr.TwoPhase], cells=cells, repeats=repeats, backend=backend,
                            schemes=list(SCHEMES.values()))
        print(f"{name}, reference {report.reference['kind']}: {report.reference['detail']}\n\n{report.work_precision('h')}")
        print(report.verdict() + "\n")
        lines = {label: [{"ms": 1e3 * row["seconds"], "error": row["error"]["h"]} for row in rows if row["error"]]
                 for label, rows in zip(SCHEMES, report.series().values(), strict=True)}
        plot_series(ax, lines, "ms", "error")
        ax.set(xlabel="wall time of the stepping, ms", ylabel="L1 error of h, m²", title=name)
    axes[-1].axis("off")
    for k, label in enumerate(SCHEMES):
        axes[-1].plot([], [], **style(k), label=label)
    axes[-1].legend(loc="center", frameon=False, title=f"Roe, {cells[0]} to {cells[-1]} cells")
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "work_precision.png", dpi=64, pil_kwargs={"optimize": True})


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Work against precision of every scheme on five scenes.")
    parser.add_argument("folder", nargs="?", type=Path, default=Path("."))
    parser.add_argument("--cells", nargs="+", type=int, default=[20, 40, 80])
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--backend", default="auto")
    given = parser.parse_args()
    main(given.folder, given.cells, given.repeats, given.backend)
