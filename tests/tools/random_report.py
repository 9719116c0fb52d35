"""`RandomReport`: the table, the files and the picture of random scenes."""

import csv
import io
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from fvkit.files import write_whole
from fvkit.output.figures import new_axes
from fvkit.studies.tables import plain, table
from tests.tools.random_draws import family_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


#: Runs that did not end well, of one model, solver and order, that are printed; the files have all.
SHOWN = 20

#: Columns of report.csv.
COLUMNS = ("model", "riemann", "order", "problems", "finished", "collapses", "broken", "p50", "p99", "p99.9", "max", "drift",
           "drift/rounding", "nonhyperbolic_faces", "seconds")


@attrs.frozen
class RandomReport:
    """Result of `random_stress`: one row per model, solver and order, with its checks and the runs that did not end well.

    Parameters
    ----------
    rows : counts, quantiles of steps over nominal steps, mass drift, ``checks``, and ``odd``, the runs to look at.
    seed, first, count : which scenes.
    machine, versions, seconds : where, with what, and how long it took.
    """

    rows: list[dict[str, Any]] = attrs.field(repr=lambda rows: f"<{len(rows)} rows>")
    seed: int
    first: int
    count: int
    machine: dict[str, Any] = attrs.field(repr=False)
    versions: dict[str, str] = attrs.field(repr=False)
    seconds: float

    @property
    def success(self) -> bool:
        """Whether every check holds."""
        return all(check["passed"] for row in self.rows for check in row["checks"])

    def table(self) -> str:
        """Return one line per model, solver and order."""
        lines = [["model", "solver", "order", "runs", "finished", "collapsed", "broken", "p50", "p99", "p99.9", "max",
                  "mass drift", "/rounding", "runs/s"]]
        for row in self.rows:
            lines.append([row["model"], row["riemann"], *(str(row[name]) for name in ("order", *COLUMNS[3:7])),
                          *(f"{row[name]:.2f}" for name in ("p50", "p99", "p99.9", "max")), f"{row['drift']:.1e}",
                          f"{row['drift/rounding']:.2f}", f"{row['problems'] / row['seconds']:.0f}"])
        return table(lines)

    def summary(self) -> str:
        """Return the table, what it means, every check that failed, and a command for every run that did not end well."""
        text = [self.table(), "p50 to max: steps over nominal steps; a collapse needs more than 20 times its nominal steps, "
                              "or ends in dt_too_small; /rounding: mass drift over its bound"]
        for row in self.rows:
            text += [f"FAIL: {_label(row)}: {check['name']} {check['value']:.3g}, bound {check['bound']:g}"
                     for check in row["checks"] if not check["passed"]]
            text += [f"  {self.reproducer(row, one)}  # {_told(one)}" for one in row["odd"][:SHOWN]]
            if len(row["odd"]) > SHOWN:
                text.append(f"  ... and {len(row['odd']) - SHOWN} more of {_label(row)}: see report.json")
        runs = sum(row["problems"] for row in self.rows)
        finished, collapsed, broken = (sum(row[name] for row in self.rows) for name in ("finished", "collapses", "broken"))
        text.append(f"{runs} runs of seed {self.seed} in {self.seconds:.0f} s: {finished} finished, {collapsed} collapsed, "
                    f"{broken} broken; " + ("all checks hold" if self.success else "FAIL"))
        return "\n".join(text)

    def reproducer(self, row: dict[str, Any], one: dict[str, Any]) -> str:
        """Return the command that makes one run again."""
        family = family_of(one["setting"])
        return (f"python -m tests.tools.random_scenes 1 --seed {self.seed} --first {one['index']} --models {row['model']} "
                f"--riemann {row['riemann']} --orders {row['order']}" + (f" --{family}" if family else ""))

    def plot(self) -> "Figure":
        """Return the picture: steps over nominal steps and the mass drift over its bound, a line per model, solver, order."""
        figure, axes = new_axes(columns=2, width=6.5, height=1.6 + 0.2 * len(self.rows))
        y, (steps, drift) = np.arange(len(self.rows)), axes
        steps.hlines(y, [row["p50"] for row in self.rows], [row["max"] for row in self.rows], color="#9db4c0")
        for name, marker in (("p50", "o"), ("p99", "s"), ("p99.9", "D"), ("max", "|")):
            steps.plot([row[name] for row in self.rows], y, marker, ms=5, label=name)
        steps.set(xscale="log", xlabel="steps / nominal steps")
        steps.legend(fontsize=8, ncols=4, loc="upper center", bbox_to_anchor=(0.5, 1.0), frameon=False)
        steps.set_yticks(y, [_label(row) for row in self.rows], fontsize=7)
        drift.barh(y, [row["drift/rounding"] for row in self.rows], color="#4c9f70")
        drift.axvline(1.0, color="#c1444b")
        drift.set(xlabel="largest mass drift / bound by rounding")
        drift.set_yticks(y, [f"{row['collapses']} collapsed, {row['broken']} broken" for row in self.rows], fontsize=7)
        for ax in axes:
            ax.set_ylim(len(self.rows) - 0.4, -1.6)
        return figure

    def save(self, folder: str | Path) -> Path:
        """Write report.json, report.csv and report.png into ``folder``, which is made if missing."""
        target = Path(folder)
        target.mkdir(parents=True, exist_ok=True)
        document = plain(attrs.asdict(self))
        write_whole(target / "report.json", lambda file: file.write(json.dumps(document, indent=1).encode()))
        text = io.StringIO()
        writer = csv.DictWriter(text, COLUMNS, extrasaction="ignore")
        writer.writeheader()
        writer.writerows(self.rows)
        write_whole(target / "report.csv", lambda file: file.write(text.getvalue().encode()))
        figure = self.plot()
        write_whole(target / "report.png", lambda file: figure.savefig(file, format="png", dpi=130))
        return target


def _label(row: dict[str, Any]) -> str:
    return f"{row['model']} {row['riemann']} order {row['order']}"


def _told(one: dict[str, Any]) -> str:
    """What happened in a run, and where."""
    drifted = f", mass drift {one['drift']:.1e}" if one["share"] > 1.0 else ""
    return f"{one['status']}{drifted}: {one['class']}, {one['setting']}, {one['bottom']}"
