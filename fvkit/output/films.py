"""Films: animations of all outputs of a solution, in files and in notebooks."""

import os
import tempfile
from base64 import b64encode
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import attrs
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fvkit import validation
from fvkit.output.plots import drawing, enlarged
from fvkit.output.results import Results


@attrs.frozen
class Film(os.PathLike):
    """An animation in a .gif or .mp4 file, which notebooks play; ``open`` and everything else that takes a path takes it."""

    path: Path

    def __fspath__(self) -> str:
        return str(self.path)

    def _repr_html_(self) -> str:
        """Return the file itself inside HTML."""
        data = b64encode(self.path.read_bytes()).decode()
        if self.path.suffix == ".mp4":
            return f'<video controls src="data:video/mp4;base64,{data}"></video>'
        return f'<img src="data:image/gif;base64,{data}">'


def animate(solution: Results, path: str | Path, kind: str | None = None, fps: int = 12, ax: Axes | None = None,
            **options: Any) -> Film:
    """Write an animation with one frame per output to a ``.gif`` file, or to ``.mp4`` if ffmpeg is installed.

    All frames have the same limits of the y axis, or of the colours of a map. Kind and options are those of `Solution.plot`.
    """
    draw = partial(drawing(solution, kind), **{**enlarged(solution, kind, **options), **options})
    target = checked_film(path)
    axes = ax if ax is not None else draw(solution, None, 0)
    figure = None if axes.figure is None else axes.figure.figure  # the top-level figure, also for axes in a subfigure
    if figure is None:
        raise ValueError("`ax` must be in a figure")
    limits = _limits(solution, draw)

    def frames() -> Iterator[None]:
        for i in range(len(solution.t)):
            _clear(axes)
            draw(solution, axes, i)
            colours = _coloured(axes)
            if colours is None:
                axes.set_ylim(*limits)
            else:
                colours.set_clim(*limits)
            yield

    return write_film(target, figure, frames(), fps)


def write_film(path: str | Path, figure: Figure, frames: Iterable[None], fps: int = 12) -> Film:
    """Write an animation of a figure, which ``frames`` has drawn anew whenever it gives an item; see `animate`."""
    from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter

    rate, target = validation.whole(fps, "fps", at_least=1), checked_film(path)
    writer: AbstractMovieWriter = FFMpegWriter(fps=rate) if target.suffix == ".mp4" else PillowWriter(fps=rate)
    with tempfile.TemporaryDirectory(dir=target.parent) as folder:
        whole = Path(folder) / target.name
        with writer.saving(figure, str(whole), dpi=100):
            for _ in frames:
                writer.grab_frame()
        os.replace(whole, target)
    return Film(target)


def checked_film(path: str | Path) -> Path:
    """Return the path of an animation, or raise ValueError if its format cannot be written."""
    from matplotlib.animation import FFMpegWriter

    target = Path(path)
    if target.suffix not in (".gif", ".mp4"):
        raise ValueError(f"an animation must end in .gif or .mp4, got {validation.shown(target.name)}")
    if target.suffix == ".mp4" and not FFMpegWriter.isAvailable():
        raise ValueError("an .mp4 needs the program ffmpeg, which is not installed: install it, or write a .gif")
    return target


def _limits(solution: Results, draw: Callable[..., Axes]) -> tuple[float, float]:
    """Return limits of the y axis, or of the colours of a map, that contain every frame, (low, high)."""
    seen = []
    for i in range(len(solution.t)):
        axes = draw(solution, None, i)
        colours = _coloured(axes)
        seen.append(axes.get_ylim() if colours is None else colours.get_clim())
    return min(low for low, _ in seen), max(high for _, high in seen)


def _coloured(axes: Axes) -> Any:
    """Return what has a colour bar on axes, None without."""
    return next((item for item in axes.collections if item.colorbar is not None), None)


def _clear(axes: Axes) -> None:
    """Clear axes, and take away their colour bar."""
    colours = _coloured(axes)
    if colours is not None:
        colours.colorbar.remove()
    axes.clear()
