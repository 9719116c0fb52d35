"""Source of the compiled time loop: a step over all tiles, and steps up to a time, the same for every kernel."""

from textwrap import indent

#: All tiles from ``begin`` to ``end``: leaves the largest speed, NaN if any is, in ``speed``, whether a state is bad in ``bad``.
_STEP = '''\
found[:] = 0
found[1] = -1
lanes = min(n, TILE) + EXTRA
for j in range(lanes):
    smx[j] = 0.0
bad = 0
ends[2, :] = 0.0
for k in range(begin, end):
    c0 = k * TILE
    nt = min(TILE, n - c0)
    closing = 1 if c0 + nt == n else 0
    bad = bad | tile(q, out, aux, edges, n, c0, nt, closing, ratio, before, after, par, values, buf, smx, ends, found)
    if k == 0:
        flux[0, :] = ends[0, :]
flux[1:, :] = ends[1:, :]
while lanes > 8:
    half = (lanes + 1) // 2
    for j in range(lanes - half):
        other = smx[half + j]
        smx[j] = other if other > smx[j] or other != other else smx[j]
    lanes = half
speed = 0.0
for j in range(lanes):
    speed = smx[j] if smx[j] > speed or smx[j] != smx[j] else speed
'''

#: Steps up to a time, before and after the text of one step.
_BEGIN = '''\
    wide()
    t = real[0]
    dt = real[1]
    outcome = PAUSED
    taken = 0
    begin = 0
    end = (n + TILE - 1) // TILE
    while taken < max_steps and t < target:
        last = dt >= (target - t) * SHY
        h = target - t if last else dt
        if not last and target - t < EVEN * dt:
            h = (target - t) / ceil((target - t) / dt * SHY)
        tries = 0
        accepted = False
        while tries < retries:
            if not last and t + h == t:
                break
            ratio = h / dx
            before = share_before * h
'''

_END = '''\
            cfl = speed * h / dx
            if cfl <= cfl_max:
                accepted = True
                break
            if not cfl < inf:
                bad = 1
                accepted = True
                break
            count[1] += 1
            tries += 1
            h = h * max(cfl_aim / cfl, SHORTEST)
            real[1] = h
            last = False
        if not accepted:
            outcome = NO_STEP
            break
        if bad != 0:
            outcome = BAD_STATE
            break
        if found[0] > 0:
            if count[2] == 0:
                count[3] = found[1]
                real[3] = t
            count[2] += found[0]
            count[5] += found[2]
            count[6] = max(count[6], found[3])
            if stop_when_lost:
                outcome = LOST_HYPERBOLICITY
                break
        q, out = out, q
        count[4] += 1
        for k in range(masses.shape[1]):
            masses[0, k] += h * flux[0, k]
            masses[1, k] += h * flux[1, k]
            masses[2, k] += dx * flux[2, k]
        t = target if last else t + h
        count[0] += 1
        taken += 1
        real[2] = max(real[2], cfl)
        dt = max(least, min(most, cfl_aim * dx / speed if speed > 0.0 else inf))
        real[0] = t
        real[1] = dt
    if outcome == PAUSED and t >= target:
        outcome = REACHED
    return outcome
'''

#: Ghost cells before a step, and the share of the step that sources take after it.
_GHOSTS = '''\
ghosts(q, aux, n, before, par, values)
after = share_after * h
'''

#: The same for a scheme with a time integrator: a program of sweeps and sums over registers. A row of ``sweeps`` holds:
#: implicit, state, rate, target (-1: none), number of terms, then register and kind of each; of ``weights``: share, weight of
#: the end fluxes, then that of each term.
_STAGED = '''\
lanes = min(n, TILE) + EXTRA
for j in range(lanes):
    smx[j] = 0.0
bad = 0
flux[:, :] = 0.0
lost = 0
first = -1
films = 0
deepest = 0
for row in range(q.shape[0]):
    for j in range(GHOSTS, GHOSTS + n):
        regs[0, row, j] = q[row, j]
if before > 0.0:
    for k in range(end):
        c0 = k * TILE
        opening(regs[0], aux, c0, min(TILE, n - c0), before, after, par, flux)
for s in range(sweeps.shape[0]):
    state = regs[sweeps[s, 1]]
    rate = regs[sweeps[s, 2]]
    into = sweeps[s, 3]
    given = values[2 * s:2 * s + 2]
    ghosts(state, aux, n, before, par, given)
    if sweeps[s, 0] == 1:
        extend(state, n)
    found[:] = 0
    found[1] = -1
    for k in range(end):
        c0 = k * TILE
        nt = min(TILE, n - c0)
        closing = 1 if c0 + nt == n else 0
        if sweeps[s, 0] == 1:
            SOURCES(state, rate, aux, edges, n, c0, nt, closing, weights[s, 0] * h, before, after, par, given, buf, smx, ends,
                    found)
        else:
            tile(state, rate, aux, edges, n, c0, nt, closing, weights[s, 0] * ratio, before, after, par, given, buf, smx, ends,
                 found)
            if k == 0:
                for m in range(flux.shape[1]):
                    flux[0, m] += weights[s, 1] * ends[0, m]
        if into >= 0:
            add_up(regs, sweeps[s], weights[s], c0 + GHOSTS, nt, ratio, h)
    if sweeps[s, 0] == 0:
        for m in range(flux.shape[1]):
            flux[1, m] += weights[s, 1] * ends[1, m]
        if s == 0 or (s == 1 and sweeps[0, 0] == 1):
            lost = found[0]
            first = found[1]
            films = found[2]
            deepest = found[3]
found[0] = lost
found[1] = first
found[2] = films
found[3] = deepest
speed = 0.0
for j in range(lanes):
    speed = smx[j] if smx[j] > speed or smx[j] != smx[j] else speed
state = regs[last_register]
for k in range(end):
    c0 = k * TILE
    bad = bad | finish(state, aux, c0, min(TILE, n - c0), before, after, par, flux)
for row in range(out.shape[0]):
    for j in range(GHOSTS, GHOSTS + n):
        out[row, j] = state[row, j]
'''

#: A sum of registers over nt entries from ``first``.
_ADD_UP = '''
def add_up(regs, sweep, weights, first, nt, ratio, h):
    for row in range(regs.shape[1]):
        dst = regs[sweep[3], row, first:first + nt]
        for m in range(sweep[4]):
            src = regs[sweep[5 + 2 * m], row, first:first + nt]
            kind = sweep[6 + 2 * m]
            factor = weights[2 + m] * (1.0 if kind == STATE else ratio if kind == TRANSPORT else h)
            if m == 0:
                for j in range(nt):
                    dst[j] = factor * src[j]
            else:
                for j in range(nt):
                    dst[j] += factor * src[j]


'''

def _advance(step: str, registers: str = "") -> str:
    """Return the text of ``advance``; ``registers`` are arguments of a staged step."""
    arguments = ("q, out, aux, edges, n, dx, target, max_steps, retries, least, most, cfl_aim, cfl_max, share_before, "
                 f"share_after,\n            stop_when_lost, {registers}"
                 "par, values, buf, smx, ends, flux, masses, real, count, found")
    return f"def advance({arguments}):\n{_BEGIN}{indent(step, 12 * ' ')}{_END}"


def driver() -> str:
    """Return ``tiles`` for threads, each its share, and ``advance`` for one, with the same step written out: a call in between
    would cost the compiler a second round over everything."""
    arguments = "begin, end, q, out, aux, edges, n, ratio, before, after, par, values, buf, smx, ends, flux, found"
    tiles = f"def tiles({arguments}):\n    wide()\n{indent(_STEP, 4 * ' ')}    return speed, bad\n"
    return f"\n{tiles}\n\n{_advance(_GHOSTS + _STEP)}"


def staged_driver(sources: str) -> str:
    """Return the driver of staged schemes, whose ghosts are filled sweep by sweep; ``sources`` is the name of the function for
    sweeps of implicit sources."""
    step = "after = share_after * h\n" + _STAGED.replace("SOURCES(", f"{sources}(")
    return _ADD_UP + _advance(step, "regs, sweeps, weights, last_register, ")
