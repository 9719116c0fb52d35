"""`StressReport`: the table, the file and the picture of a stress run."""

import json
from pathlib import Path
from typing import Any

import attrs
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from fvkit.output.figures import new_axes, save_all
from fvkit.studies.tables import plain, table
from fvkit_granular.stress.known_limits import LIMITS

#: Verdicts from best to worst, with their colours.
VERDICTS = {"pass": "#4c9f70", "expected": "#e3b23c", "BETTER": "#3d7ea6", "FAIL": "#c1444b"}

BAD = ("FAIL", "BETTER")


@attrs.frozen
class StressReport:
    """Result of `stress`: one row per run, with its checks and verdict."""

    rows: list[dict[str, Any]] = attrs.field(repr=lambda rows: f"<{len(rows)} rows>")
    machine: dict[str, Any]
    versions: dict[str, str]
    seconds: float

    @property
    def success(self) -> bool:
        """Whether exactly the runs with a known limit failed."""
        return not any(row["verdict"] in BAD for row in self.rows)

    def summary(self) -> str:
        """Return one line per scene, then every run that failed, and the known limits that were met."""
        lines = [["scene", "runs", "pass", "expected", "FAIL", "tightest check", "value", "bound", "steps/nominal", "ms"]]
        for name in dict.fromkeys(row["scene"] for row in self.rows):
            rows = [row for row in self.rows if row["scene"] == name]
            count = {verdict: sum(row["verdict"] == verdict for row in rows) for verdict in VERDICTS}
            check = max((check for row in rows for check in row["checks"]), key=_tension)
            lines.append([name, str(len(rows)), str(count["pass"]), str(count["expected"]), str(count["FAIL"] + count["BETTER"]),
                          check["name"], f"{check['value']:.1e}", f"{check['bound']:.1e}",
                          f"{max(row['steps'] / row['nominal'] for row in rows):.1f}",
                          f"{1e3 * max(row['seconds'] for row in rows):.0f}"])
        text = [table(lines)]
        text += [f"{row['verdict']}: {_label(row)}: {_failures(row)}" for row in self.rows if row["verdict"] in BAD]
        text += [f"known limit: {limit.check}, {limit.where}: {limit.cause} ({limit.size})" for limit in LIMITS
                 if any(limit.matches(row) for row in self.rows)]
        total = {verdict: sum(row["verdict"] == verdict for row in self.rows) for verdict in VERDICTS}
        counts = ", ".join(f"{count} {verdict}" for verdict, count in total.items() if count)
        text.append(f"{len(self.rows)} runs in {self.seconds:.0f} s: {counts}")
        return "\n".join(text)

    def table(self) -> str:
        """Return one line per run: verdict, steps against nominal, time, and each check with value and bound."""
        lines = [["verdict", "scene", "model", "solver", "order", "backend", "steps", "nominal", "ms", "checks: value <= bound"]]
        lines += [[*(str(row[key]) for key in ("verdict", "scene", "model", "riemann", "order", "backend", "steps")),
                   f"{row['nominal']:.0f}", f"{1e3 * row['seconds']:.1f}",
                   "; ".join(f"{check['name']} {check['value']:.1e} <= {check['bound']:.1e}" for check in row["checks"])]
                  for row in self.rows]
        return table(lines)

    def plot(self) -> Figure:
        """Return the picture: scenes against models and solvers, coloured by the worst verdict."""
        scenes = list(dict.fromkeys(row["scene"] for row in self.rows))
        columns = sorted({(row["model"], row["riemann"]) for row in self.rows})
        figure, axes = new_axes(width=2.5 + 0.34 * len(columns), height=1.8 + 0.27 * len(scenes))
        ax, order = axes[0], list(VERDICTS)
        for y, name in enumerate(scenes):
            for x, column in enumerate(columns):
                found = [row for row in self.rows if row["scene"] == name and (row["model"], row["riemann"]) == column]
                if found:
                    worst = max((row["verdict"] for row in found), key=order.index)
                    ax.add_patch(Rectangle((x - 0.46, y - 0.46), 0.92, 0.92, color=VERDICTS[worst]))
                    ax.text(x, y, str(len(found)), ha="center", va="center", fontsize=7, color="white")
        ax.set(xlim=(-0.5, len(columns) - 0.5), ylim=(len(scenes) - 0.5, -0.5), title="Worst verdict; the number counts runs")
        ax.set_xticks(range(len(columns)), [f"{model} {solver}" for model, solver in columns], rotation=90, fontsize=8)
        ax.set_yticks(range(len(scenes)), scenes, fontsize=8)
        ax.set_aspect("equal")
        ax.legend(handles=[Patch(color=colour, label=verdict) for verdict, colour in VERDICTS.items()], loc="upper left",
                  bbox_to_anchor=(1.01, 1.0), fontsize=8, frameon=False)
        return figure

    def save(self, folder: str | Path) -> Path:
        """Write stress.json, stress.txt and stress.png into ``folder``, which is made if missing."""
        document = plain({"machine": self.machine, "versions": self.versions, "seconds": self.seconds, "rows": self.rows,
                          "limits": [attrs.asdict(limit) for limit in LIMITS]})
        text = f"{self.table()}\n\n{self.summary()}\n"
        return save_all(folder, {"stress.json": json.dumps(document, indent=1), "stress.txt": text, "stress.png": self.plot()})


def _tension(check: dict[str, Any]) -> float:
    """How near a check is to its bound, failed ones first."""
    if not check["passed"]:
        return float("inf")
    return check["value"] / check["bound"] if check["bound"] else 0.0


def _label(row: dict[str, Any]) -> str:
    return f"{row['scene']} {row['model']} {row['riemann']} order {row['order']} {row['backend']}"


def _failures(row: dict[str, Any]) -> str:
    bad = [f"{check['name']} {check['value']:.2e}, bound {check['bound']:.1e}" for check in row["checks"] if not check["passed"]]
    return "; ".join(bad) or "a known failure passes: remove it from the list"
