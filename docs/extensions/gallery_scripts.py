"""The examples as a gallery: each script runs as on the command line, and the pictures that it writes are shown.

The scripts take a folder and know nothing of the gallery; figures of fvkit live without pyplot, where sphinx-gallery
would find none.
"""

import atexit
import shutil
import tempfile
from pathlib import Path
from typing import Any

from sphinx_gallery.scrapers import figure_rst

#: Arguments after the folder. Scripts run inside the builder, from where no process can be started: hence one worker.
OPTIONS = {"hazard_ensemble": ["--workers", "1", "--quiet"], "internal_shocks": ["100", "200", "400"]}

FOLDER = Path(tempfile.mkdtemp(prefix="fvkit-gallery-"))
atexit.register(shutil.rmtree, FOLDER, ignore_errors=True)


def arguments(gallery_conf: dict[str, Any], script_vars: dict[str, Any]) -> list[str]:
    """Return what the script finds in sys.argv behind its name."""
    name = Path(script_vars["src_file"]).stem
    return [str(FOLDER / name), *OPTIONS.get(name, [])]


def pictures(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Take the pictures that the script has written into the gallery."""
    taken = []
    for picture in sorted((FOLDER / Path(block_vars["src_file"]).stem).glob("*.png")):
        target = Path(next(block_vars["image_path_iterator"]))
        target.write_bytes(picture.read_bytes())
        picture.unlink()
        taken.append(str(target))
    return "\n".join(figure_rst([picture], gallery_conf["src_dir"]) for picture in taken)


def setup(app: Any) -> dict[str, bool]:
    """An extension so that Sphinx imports this file."""
    return {"parallel_read_safe": True}
