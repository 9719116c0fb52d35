"""Faces at which a static force holds a phase: no waves there, and nothing paid for twice."""

from fvkit.pointwise import where


def jumps(parts, ql, qr, auxl, auxr):
    """Return the jump of a face, and what static forces leave of it; the same object where there are none."""
    whole = net = parts.model.jump(ql, qr, auxl, auxr)
    for source in parts.sources:
        if source.defines("limit_jump"):
            net = source.limit_jump(parts.model, ql, qr, auxl, auxr, net, parts.dx)
    return whole, net


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
    if jump is whole:
        return whole
    return tuple([left if left is every else where(left == 0.0, 0.0, every) for left, every in zip(jump, whole, strict=True)])
