"""The text of the compiled time loop, the same for every kernel: one step over all tiles, and steps up to a time."""

#: Selections as single instructions: a conditional expression would cost the compiler two blocks each.
SELECT = '''
from numba import boolean, float64, int64
from numba.extending import intrinsic


@intrinsic
def select(typing_context, condition, a, b):
    def code(context, builder, signature, arguments):
        return builder.select(*arguments)

    return float64(boolean, float64, float64), code


@intrinsic
def larger(typing_context, a, b):
    def code(context, builder, signature, arguments):
        return builder.select(builder.fcmp_ordered(">", *arguments), *arguments)

    return float64(float64, float64), code


@intrinsic
def smaller(typing_context, a, b):
    def code(context, builder, signature, arguments):
        return builder.select(builder.fcmp_ordered("<", *arguments), *arguments)

    return float64(float64, float64), code


@intrinsic
def flag(typing_context, condition):
    def code(context, builder, signature, arguments):
        return builder.zext(arguments[0], context.get_value_type(int64))

    return int64(boolean), code
'''

#: exp in arithmetic that vectorises: 2^k times a polynomial on |r| <= ln(2)/2, to one unit in the last place. Results below
#: the normal range are 0.
EXP = '''
from numba import njit


@intrinsic
def bits_to_float(typing_context, bits):
    from llvmlite import ir

    def code(context, builder, signature, arguments):
        return builder.bitcast(arguments[0], ir.DoubleType())

    return float64(int64), code


@njit(forceinline=True, error_model="numpy", fastmath={"contract"}, nogil=True)
def exp(x):
    y = 709.0 if x > 709.0 else x
    y = -708.0 if y < -708.0 else y
    shifted = y * 1.4426950408889634 + 6755399441055744.0
    k = shifted - 6755399441055744.0
    r = (y - k * 0.6931471803691238) - k * 1.9082149292705877e-10
    p = 2.08767569878681e-09
    p = p * r + 2.505210838544172e-08
    p = p * r + 2.755731922398589e-07
    p = p * r + 2.7557319223985893e-06
    p = p * r + 2.48015873015873e-05
    p = p * r + 1.984126984126984e-04
    p = p * r + 1.3888888888888889e-03
    p = p * r + 8.333333333333333e-03
    p = p * r + 4.1666666666666664e-02
    p = p * r + 0.16666666666666666
    p = p * r + 0.5
    p = p * r + 1.0
    p = p * r + 1.0
    result = p * bits_to_float((int64(k) + 1023) << 52)
    result = inf if x > 709.782712893384 else result
    return 0.0 if x < -708.0 else result
'''

DRIVER = '''
def tiles(begin, end, q, out, aux, n, ratio, before, after, par, buf, smx, ends, flux, found):
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
        bad = bad | tile(q, out, aux, c0, nt, closing, ratio, before, after, par, buf, smx, ends, found)
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
    return speed, bad


def step(q, out, aux, n, ratio, before, after, par, values, buf, smx, ends, flux, found):
    ghosts(q, n, par, values)
    return tiles(0, (n + TILE - 1) // TILE, q, out, aux, n, ratio, before, after, par, buf, smx, ends, flux, found)


def advance(q, out, aux, n, dx, target, max_steps, retries, cfl_aim, cfl_max, before, after, stop_when_lost,
            par, values, buf, smx, ends, flux, masses, real, count, found):
    t = real[0]
    dt = real[1]
    outcome = PAUSED
    taken = 0
    while taken < max_steps and t < target:
        last = dt >= (target - t) * (1.0 - 1e-12)
        h = target - t if last else dt
        tries = 0
        accepted = False
        while tries < retries:
            if not last and t + h == t:
                break
            speed, bad = step(q, out, aux, n, h / dx, before * h, after * h, par, values, buf, smx, ends, flux, found)
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
