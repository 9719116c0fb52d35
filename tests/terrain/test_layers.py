"""Styles of rasters for QGIS, from one table of layers."""

import re
from xml.etree import ElementTree

import pytest

from fvkit.cli import main
from fvkit_granular.observers.hazard import MAPS
from fvkit_granular.studies.hazard_report import is_record
from fvkit_granular.terrain.layers import LAYERS, PROBABILITY, style, write_style
from tests.terrain.test_command import folder  # noqa: F401


@pytest.mark.parametrize("layer", [*LAYERS, PROBABILITY], ids=lambda layer: layer.name)
def test_a_style_has_a_colour_for_every_value_and_none_where_nothing_came(layer, tmp_path):
    path = write_style(tmp_path / "max.depth.asc", layer)
    assert path.name == "max.depth.qml"
    root = ElementTree.parse(path).getroot()
    assert (root.tag, root.find(".//rasterrenderer").get("type")) == ("qgis", "singlebandpseudocolor")
    items = root.findall(".//colorrampshader/item")
    bounds = [float(item.get("value")) for item in items]  # a class holds what is up to its bound
    assert bounds == [*sorted(layer.classes), float("inf")]
    assert [item.get("alpha") for item in items] == ["0"] + ["255"] * len(layer.classes)
    colours = [item.get("color") for item in items[1:]]
    assert all(re.fullmatch("#[0-9a-f]{6}", colour) for colour in colours)
    assert len(set(colours)) == len(colours)
    assert "<" not in items[0].get("label")[1:]
    assert root.find(".//colorrampshader").get("colorRampType") == "DISCRETE"
    assert style(layer) == path.read_text()


def test_every_layer_is_a_map_and_every_map_a_layer():
    assert {layer.key for layer in LAYERS} == {*MAPS, "thickness", None}
    by_key = {layer.key: layer for layer in LAYERS}
    for name, nothing in MAPS.items():  # what a cell has where no flow came is not drawn, or no data
        assert not nothing > by_key[name].classes[0] or nothing == float("inf")


def test_a_run_writes_a_style_beside_every_raster_and_takes_old_ones_along(folder, capsys):  # noqa: F811
    assert main(["run", "scene.toml", "--out", "out", "--model", "shallow-water"]) == 0
    named = capsys.readouterr().out.split("written to out/: ")[1].strip().split(", ")
    rasters = [name for name in named if name.endswith(".asc")]
    assert len(rasters) == len(LAYERS)
    for name in rasters:
        assert name.replace(".asc", ".qml") in named
        assert (folder / "out" / name.replace(".asc", ".qml")).exists()
    assert all(is_record(name) for name in named if name.endswith(".qml"))
