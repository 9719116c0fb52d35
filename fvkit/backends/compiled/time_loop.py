"""Source of the compiled time loop: the sweeps of a step, and steps up to a time, the same for every kernel."""

#: Functions of a kernel whose addresses a loop is given, in this order; the last four those of schemes with registers.
ADDRESSES = ("tile", "ghosts", "opening", "finish", "extend", "source_tile")

#: Kernels are called by their addresses ``at``, see `ADDRESSES`. A row of ``sweeps`` is a `fvkit.schemes.program.StageSweep`:
#: implicit, state, rate, target (-1: none), number of terms, then register and kind of each; of ``weights``: share, weight of the
#: end fluxes, then that of each term. A loop without REGISTERS has one sweep, from q to out.
LOOP = '''\
def add_up(regs, sweep, weights, first, nt, ratio, h):
    for m in range(sweep[4]):
        target = regs[sweep[3]]
        source = regs[sweep[5 + 2 * m]]
        kind = sweep[6 + 2 * m]
        factor = weights[2 + m] * (1.0 if kind == STATE else ratio if kind == TRANSPORT else h)
        for row in range(target.shape[0]):
            if m == 0:
                for j in range(first, first + nt):
                    target[row, j] = factor * source[row, j]
            else:
                for j in range(first, first + nt):
                    target[row, j] += factor * source[row, j]


def fill(at, q, aux, n, before, par, values):
    """Ghost cells for threads, which share the tiles of a sweep."""
    ghosts(at[1], q, aux, n, before, par, values)


def step(at, begin, end, filled, q, out, aux, edges, n, ratio, h, before, after, cfl_max, par, values, regs, sweeps, weights,
         last_register, buf, smx, ends, flux, found):
    """A step of length h on the tiles from ``begin`` to ``end``; the largest speed, NaN if any is, and whether a state is bad."""
    wide()
    halo = (q.shape[1] - n) // 2
    for m in range(flux.shape[1]):  # slices take long to compile
        flux[0, m] = 0.0
        flux[1, m] = 0.0
        flux[2, m] = 0.0
        ends[2, m] = 0.0
    speed = 0.0
    bad = 0
    state = q
    rate = out
    if REGISTERS:
        for row in range(q.shape[0]):
            for j in range(halo, halo + n):
                regs[0, row, j] = q[row, j]
        if before > 0.0:
            for k in range(end):
                c0 = k * TILE
                opening(at[2], regs[0], aux, c0, min(TILE, n - c0), before, after, par, flux)
    for s in range(sweeps.shape[0]):
        kernel = at[0]
        length = weights[s, 0] * ratio
        given = values[s]
        counts = found[0] if s == sweeps[0, 0] else found[1]
        if REGISTERS:
            state = regs[sweeps[s, 1]]
            rate = regs[sweeps[s, 2]]
        if not filled:
            ghosts(at[1], state, aux, n, before, par, given)
        if REGISTERS:
            if sweeps[s, 0] == 1:
                extend(at[4], state, n)
                kernel = at[5]
                length = weights[s, 0] * h
        for m in range(4):
            counts[m] = -1 if m == 1 else 0
        lanes = min(n, TILE) + SPARE
        for j in range(lanes):
            smx[j] = 0.0
        for k in range(begin, end):
            c0 = k * TILE
            nt = min(TILE, n - c0)
            closing = 1 if c0 + nt == n else 0
            bad = bad | tile(kernel, state, rate, aux, edges, n, c0, nt, closing, length, before, after, par, given, buf, smx,
                             ends, counts)
            if sweeps[s, 0] == 0:
                for m in range(flux.shape[1]):
                    if k == 0:
                        flux[0, m] += weights[s, 1] * ends[0, m]
                    if closing == 1:
                        flux[1, m] += weights[s, 1] * ends[1, m]
            if REGISTERS:
                add_up(regs, sweeps[s], weights[s], c0 + halo, nt, ratio, h)
        while lanes > 8:
            half = (lanes + 1) // 2
            for j in range(lanes - half):
                other = smx[half + j]
                smx[j] = other if other > smx[j] or other != other else smx[j]
            lanes = half
        fastest = 0.0
        for j in range(lanes):
            fastest = smx[j] if smx[j] > fastest or smx[j] != smx[j] else fastest
        if fastest == fastest:
            speed = max(speed, fastest)
        elif speed * ratio <= cfl_max:  # else the step is too long, whatever later stages say
            speed = fastest
    for m in range(flux.shape[1]):
        flux[2, m] += ends[2, m]
    if REGISTERS:
        state = regs[last_register]
        for k in range(end):
            c0 = k * TILE
            bad = bad | finish(at[3], state, aux, c0, min(TILE, n - c0), before, after, par, flux)
        for row in range(out.shape[0]):
            for j in range(halo, halo + n):
                out[row, j] = state[row, j]
    return speed, bad


def advance(at, q, out, aux, edges, n, dx, target, max_steps, retries, least, most, cfl_aim, cfl_max, share_before, share_after,
            stop_when_lost, par, values, regs, sweeps, weights, last_register, buf, smx, ends, flux, found, masses, real, count):
    """Steps up to a time, see `Kernel.advance`."""
    wide()
    t = real[0]
    dt = real[1]
    outcome = PAUSED
    taken = 0
    while taken < max_steps and t < target:
        last = dt >= (target - t) * NEARLY_ONE
        h = target - t if last else dt
        if not last and target - t < EQUALISED * dt:
            h = (target - t) / ceil((target - t) / dt * NEARLY_ONE)
        tries = 0
        accepted = False
        while tries < retries:
            if not last and t + h == t:
                break
            speed, bad = step(at, 0, (n + TILE - 1) // TILE, False, q, out, aux, edges, n, h / dx, h, share_before * h,
                              share_after * h, cfl_max, par, values, regs, sweeps, weights, last_register, buf, smx, ends,
                              flux, found)
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
        if found[0, 0] > 0:
            if count[2] == 0:
                count[3] = found[0, 1]
                real[3] = t
            count[2] += found[0, 0]
            count[5] += found[0, 2]
            count[6] = max(count[6], found[0, 3])
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
