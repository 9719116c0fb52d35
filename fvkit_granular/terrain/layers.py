"""Layers of results: what each raster of a run shows, its classes and colours, and its style for QGIS (``.qml``)."""

from pathlib import Path
from typing import NamedTuple
from xml.sax.saxutils import quoteattr

from fvkit.files import write_whole


class Layer(NamedTuple):
    """A raster of results.

    Parameters
    ----------
    name : of its file.
    key : map of `HazardMaps`; None for one of another origin.
    shows : what pictures of it show, with their unit, for colour bars.
    least : value up to which pictures leave it out; None for no picture.
    classes : ascending bounds of the classes of its style, in its unit; up to the first nothing is drawn.
    colours : name of matplotlib's colour map of the style.
    unit : that of pictures over that of the raster.
    """

    name: str
    key: str | None
    shows: str
    least: float | None
    classes: tuple[float, ...]
    colours: str = "viridis_r"
    unit: float = 1.0


DEPTHS = (0.01, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
TIMES = (0.0, 5.0, 10.0, 20.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1800.0, 3600.0)

#: Rasters of a run. Pressures have classes in use for snow avalanches: 3 and 30 kPa bound zones of danger in Switzerland.
LAYERS = (
    Layer("max_depth", "depth", "largest depth (vertical), m", 0.01, DEPTHS),
    Layer("max_thickness", "thickness", "largest thickness, m", None, DEPTHS),
    Layer("max_speed", "speed", "largest speed, m/s", 0.0, (0.01, 1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 40.0), "plasma_r"),
    Layer("max_pressure", "pressure", "largest dynamic pressure, kPa", 0.0, (1.0, 1e3, 3e3, 1e4, 3e4, 1e5, 3e5), "inferno_r",
          1e3),
    Layer("phi_at_max_depth", "phi", "solid fraction at the largest depth", None,
          (-1.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)),
    Layer("arrival", "arrival", "first arrival, s", -1e-9, (-1.0, *TIMES[1:]), "cividis"),
    Layer("duration", "duration", "duration, s", None, TIMES, "cividis_r"),
    Layer("deposit", None, "depth at the end, m", None, DEPTHS))

#: Rasters of a sweep: all that begin with this name.
PROBABILITY = Layer("probability", None, "probability", 0.0, (0.0, 0.01, 0.05, 0.1, 0.25, 0.5, 0.75, 0.9), "magma_r")


def write_style(raster: Path, layer: Layer) -> Path:
    """Write the style of a raster beside it, which QGIS takes when it opens the raster, and return its path."""
    return write_whole(raster.with_suffix(".qml"), style(layer))


def style(layer: Layer) -> str:
    """Return the style of a layer for QGIS: a colour for each class, nothing up to the first bound."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    bounds, last = layer.classes, len(layer.classes) - 1
    rows = [(bounds[0], f"<= {bounds[0]:g}", "#ffffff", 0)]
    for k, low in enumerate(bounds):
        high = bounds[k + 1] if k < last else float("inf")
        named = f"{low:g} - {high:g}" if k < last else f"> {low:g}"
        rows.append((high, named, to_hex(colormaps[layer.colours](0.05 + 0.95 * k / max(last, 1))), 255))
    items = "\n".join(f'          <item value="{value:g}" label={quoteattr(label)} color="{colour}" alpha="{alpha}"/>'
                      for value, label, colour, alpha in rows)
    return f"""<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>
<qgis version="3.16" styleCategories="Symbology">
  <pipe>
    <rasterrenderer type="singlebandpseudocolor" band="1" opacity="0.85" alphaBand="-1" classificationMin="{bounds[0]:g}" \
classificationMax="inf">
      <rasterTransparency/>
      <rastershader>
        <colorrampshader colorRampType="DISCRETE" classificationMode="1" clip="0" minimumValue="{bounds[0]:g}" maximumValue="inf">
{items}
        </colorrampshader>
      </rastershader>
    </rasterrenderer>
  </pipe>
  <blendMode>0</blendMode>
</qgis>
"""
