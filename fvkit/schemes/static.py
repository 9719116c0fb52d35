"""Faces at which a static force holds a phase: no waves there, and nothing paid for twice."""

from fvkit.pointwise import where


def without_held(model, whole, jump, waves):
    """Return the waves without the rows of a phase that static forces hold at this face: neither viscosity nor the waves
    of another phase then move it."""
    result = [list(wave) for wave in waves]
    for masses, momentum in model.phases:
        held = (whole[momentum] != 0.0) & (jump[momentum] == 0.0)
        for row in masses:
            held = held & (jump[row] == 0.0)
        for wave in result:
            for row in (*masses, momentum):
                wave[row] = where(held, 0.0, wave[row])
    return tuple(map(tuple, result))


def sliding(whole, jump):
    """Return the jump that the cells of a face get: the whole of it where a push is left, since there they pay for the
    static force themselves.

    The sources take it from what moves, and would take it twice. So the waves, and with them the masses, feel the net push,
    and the rest is given back as a standing wave, half to each cell.
    """
    return tuple([left if left is every else where(left == 0.0, 0.0, every) for left, every in zip(jump, whole, strict=True)])
