"""Small problems with two axes that several tests share."""

import numpy as np

import fvkit as fv
import fvkit_granular as gr

#: Cells of the problems: not square, so that axes that change places are seen.
CELLS = (12, 7)


def pool(model=None, cells=CELLS, t_end=0.4, **options):
    """A dam that breaks over a hill, with a gap in the eastern wall; two phases where the model has them."""
    model = gr.ShallowWater() if model is None else model
    two = len(model.phases) == 2

    def initial(x, y):
        h = np.where(x + 0.3 * y < 2.0, 2.0, 1.0)
        still = 0.0 * x
        return [0.5 * h, still, still, 0.5 * h, 0.1 * h, still] if two else [h, still, 0.1 * h]

    return fv.Problem(model, fv.Grid((0.0, -1.0), (6.0, 2.5), cells), initial, t_end,
                      aux={"b": lambda x, y: 0.4 * np.exp(-((x - 4.0) ** 2) - (y - 1.0) ** 2)},
                      boundary={"west": fv.Wall(), "south": fv.Wall(), "north": fv.Wall(),
                                "east": fv.Along(0.0, 1.0, fv.Outflow(), fv.Along(-1.0, -0.5, fv.Outflow()))}, **options)


def same_bits(one, other):
    """Whether two arrays have the same shape and the same bytes."""
    return one.shape == other.shape and one.tobytes() == other.tobytes()
