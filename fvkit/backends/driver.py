"""The text of the compiled time loop, the same for every kernel: one step over all tiles, and steps up to a time."""

from textwrap import indent

#: All tiles from ``begin`` to ``end``: leaves the largest speed in ``speed``, whether a state is bad in ``bad``.
_STEP = '''\
found[0] = 0
found[1] = -1
lanes = min(n, TILE) + EXTRA
for j in range(lanes):
    smx[j] = 0.0
bad = 0
for k in range(begin, end):
    c0 = k * TILE
    nt = min(TILE, n - c0)
    closing = 1 if c0 + nt == n else 0
    bad = bad | tile(q, out, aux, edges, n, c0, nt, closing, ratio, before, after, par, buf, smx, ends, found)
    if k == 0:
        flux[0, :] = ends[0, :]
flux[1, :] = ends[1, :]
while lanes > 8:
    half = (lanes + 1) // 2
    for j in range(lanes - half):
        other = smx[half + j]
        smx[j] = other if other > smx[j] else smx[j]
    lanes = half
speed = 0.0
for j in range(lanes):
    speed = max(speed, smx[j])
'''

_TILES = '''
def tiles(begin, end, q, out, aux, edges, n, ratio, before, after, par, buf, smx, ends, flux, found):
@@
    return speed, bad


'''

_ADVANCE = '''\
def advance(q, out, aux, edges, n, dx, target, max_steps, retries, cfl_aim, cfl_max, share_before, share_after, stop_when_lost,
            par, values, buf, smx, ends, flux, masses, real, count, found):
    t = real[0]
    dt = real[1]
    outcome = PAUSED
    taken = 0
    begin = 0
    end = (n + TILE - 1) // TILE
    while taken < max_steps and t < target:
        last = dt >= (target - t) * (1.0 - 1e-12)
        h = target - t if last else dt
        if not last and target - t < EVEN * dt:
            h = (target - t) / ceil((target - t) / dt)
        tries = 0
        accepted = False
        while tries < retries:
            if not last and t + h == t:
                break
            ghosts(q, n, par, values)
            ratio = h / dx
            before = share_before * h
            after = share_after * h
@@
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
            h = h * cfl_aim / cfl
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
            if stop_when_lost:
                outcome = LOST_HYPERBOLICITY
                break
        q, out = out, q
        count[4] += 1
        for k in range(masses.shape[1]):
            masses[0, k] += h * flux[0, k]
            masses[1, k] += h * flux[1, k]
        t = target if last else t + h
        count[0] += 1
        taken += 1
        real[2] = max(real[2], cfl)
        dt = cfl_aim * dx / speed if speed > 0.0 else inf
        real[0] = t
        real[1] = dt
    if outcome == PAUSED and t >= target:
        outcome = REACHED
    return outcome
'''

#: ``tiles`` for threads, each its share; ``advance`` for one, with the same step written out: a call in between would cost
#: the compiler a second round over everything.
DRIVER = _TILES.replace("@@\n", indent(_STEP, 4 * " ")) + _ADVANCE.replace("@@\n", indent(_STEP, 12 * " "))
