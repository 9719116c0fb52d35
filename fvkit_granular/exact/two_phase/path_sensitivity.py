"""Path sensitivity: spread of the speed of internal shocks over paths, which the model does not determine."""

from collections.abc import Sequence
from typing import Any

from fvkit_granular.exact.states import NoFourWaveSolution
from fvkit_granular.exact.two_phase.riemann import two_phase_riemann

#: The paths compared: three that are as good as one another. The first is that of the Roe matrix.
REASONABLE = ("depths", "h-phi", "sqrt")


def path_sensitivity(left: Sequence[float], right: Sequence[float], g: float = 9.81, gamma: float = 0.5) -> dict[str, Any] | None:
    """Return the spread of the speeds of the internal shocks over reasonable paths, beside which errors are to be judged.

    Parameters
    ----------
    left, right : (h, phi, vs, vf), as for `two_phase_riemann`.
    g, gamma : gravity, m/s^2, and density ratio in (0, 1).

    Returns
    -------
    dict or None
        ``shocks``: {family: {"speeds": {path: m/s}, "spread": largest less smallest, m/s, "percent": of the speed on the
        segment path}}; ``text``: one line. Paths without a solution, or with a fan in its place, are missing. None where no
        internal shock exists on the segment path.

    Raises
    ------
    ValueError
        As `two_phase_riemann` for the segment path.
    """
    solutions = {REASONABLE[0]: two_phase_riemann(left, right, g, gamma)}
    for path in REASONABLE[1:]:
        try:
            solutions[path] = two_phase_riemann(left, right, g, gamma, path)
        except NoFourWaveSolution:
            continue
    shocks: dict[str, dict[str, Any]] = {}
    for family in (2, 3):
        waves = {path: solution.waves[family - 1] for path, solution in solutions.items()}
        speeds = {path: wave.shock for path, wave in waves.items() if wave.shock is not None and not wave.absent}
        first = speeds.get(REASONABLE[0])
        if first is not None:
            spread = max(speeds.values()) - min(speeds.values())
            shocks[str(family)] = {"speeds": speeds, "spread": spread, "percent": 100.0 * spread / abs(first) if first else None}
    if not shocks:
        return None
    return {"shocks": shocks, "text": "Path sensitivity: " + "; ".join(map(_line, shocks, shocks.values()))
            + ". The model leaves this open: a speed error below the spread is no reason to prefer a scheme."}


def _line(family: str, shock: dict[str, Any]) -> str:
    """Sentence about one shock."""
    others = ", ".join(f"{speed:.4f} ({path})" for path, speed in shock["speeds"].items() if path != REASONABLE[0])
    share = "" if shock["percent"] is None else f", a spread of {shock['percent']:.1f} %"
    return f"internal {family}-shock at {shock['speeds'][REASONABLE[0]]:.4f} m/s ({REASONABLE[0]}), {others}{share}"
