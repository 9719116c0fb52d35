"""AvaFrame's test avaKot: an avalanche on a real terrain, against the stored result of com1DFA. Another program's result, not a measurement.

    python -m tests.benchmarks.kot FOLDER [--curvature]

FOLDER holds what AvaFrame's repository (OpenNHM/AvaFrame, EUPL-1.2) has of the case: avaKot.asc, REL/relKot.shp, and
com1DFA_reference/*_pft.tif, *_pfv.tif, *_ppr.tif. (Terrain: Land Tirol, data.tirol.gv.at; release: Austrian Torrent and Avalanche Service.) Needs
the extra ``geo``. Cells of 5 m (the file has 4.998), release 1 m thick normal to the ground, 118 s, the friction law of that program (samosATSmall):

    R = mu N (1 + R0/(R0 + Rs)) + v^2/(h (ln(h/r)/kappa + B)^2),   Rs = v^2/(h N),   N the load per mass.

com1DFA follows 3466 particles over thickness normal to the ground; the areas above 0.1 m, 1 kPa and 10 m/s are compared by cells.
"""

import time

import attrs
import numpy as np

import fvkit as fv
import fvkit_granular as gr
from tests.benchmarks.chapter import asked

DENSITY, THRESHOLD = 200.0, 0.1


@attrs.frozen
class SamosAT(gr.BasalFriction):
    """Friction of dense avalanches: Coulomb friction that a fast flow lessens, and a logarithmic profile of velocity."""

    mu: float = 0.22
    R0: float = 0.222
    kappa: float = 0.43
    B: float = 4.13
    r: float = 0.05

    def resistance(self, model, load, h, speed):
        square = speed * speed
        profile = np.log(fv.maximum(h / self.r, 1.0)) / self.kappa + self.B
        number = square / fv.maximum(h * load, 1e-12)
        return self.mu * load * (1.0 + self.R0 / (self.R0 + number)) + square / (h * profile * profile)


def run(folder, curvature):
    """Return hazard maps, terrain and stored rasters {name: (ny, nx)}."""
    terrain = gr.read_terrain(folder / "avaKot.asc", cell=5.0)
    release = gr.read_release(folder / "REL" / "relKot.shp", terrain, thickness=1.0, measured="normal")
    sources = (SamosAT(), *([gr.Curvature()] if curvature else []))
    scene = gr.Scene(terrain=terrain, release=release, t_end=118.0, phi=0.5, sources=sources)
    hazard = gr.HazardMaps(threshold=THRESHOLD, density=DENSITY)
    started = time.process_time()
    solution = fv.solve(scene.problem(gr.ShallowWater), observers=hazard)
    print(f"{solution}\nCPU time with problem and maxima {time.process_time() - started:.1f} s; "
          f"speed at the end {solution.observables()['speed'].max():.1f} m/s", flush=True)
    stored = {name: _raster(folder / "com1DFA_reference", name) for name in ("pft", "pfv", "ppr")}
    return hazard.maps, terrain, stored


def _raster(folder, name):
    import rasterio

    [path] = folder.glob(f"*_{name}.tif")
    with rasterio.open(path) as file:
        return np.nan_to_num(file.read(1)[::-1].astype(float))


def main():
    given = asked(__doc__, folder=None, curvature=False)
    maps, terrain, stored = run(given.folder, given.curvature)
    pairs = {"thickness, m": (maps["thickness"], stored["pft"], THRESHOLD), "pressure, kPa": (1e-3 * maps["pressure"], stored["ppr"], 1.0),
             "speed, m/s": (maps["speed"], stored["pfv"], 10.0)}
    print("| | above | area, m2 | com1DFA | hit rate | false alarm ratio | critical success index | largest | com1DFA |\n" + "|---" * 9 + "|")
    for name, (own, other, above) in pairs.items():
        score = gr.compare_outline(own, (other > above).astype(float), terrain, above)
        area = terrain.grid.cell_volume
        print(f"| {name} | {above:g} | {area * (own > above).sum():.0f} | {area * (other > above).sum():.0f} | {score.hit_rate:.3f} | "
              f"{score.false_alarm_ratio:.3f} | {score.critical_success_index:.3f} | {own.max():.1f} | {other.max():.1f} |")
    low = [float(np.nanmin(np.where(own > above, terrain.bottom, np.nan))) for own, other, above in pairs.values() for own in (own, other)]
    print("lowest ground reached, m: " + ", ".join(f"{name} {a:.0f} (com1DFA {b:.0f})" for name, a, b in zip(pairs, low[::2], low[1::2], strict=True)))


if __name__ == "__main__":
    main()
