"""Plan of a scheme: the range of cells and faces that each stage covers, and the number of ghost cells."""

import attrs

from fvkit.schemes.scheme import MASS_FLUX, Stage


@attrs.frozen
class Plan:
    """Ranges of the stages of a scheme over a tile of n cells, (low, high) per stage: it covers the places low .. n + high - 1.

    ``halo`` is the number of ghost cells needed on each side.
    """

    stages: tuple[Stage, ...]
    ranges: tuple[tuple[int, int], ...]
    halo: int

    @property
    def last_mass_flux(self) -> Stage | None:
        """The stage after which the mass fluxes are complete; None where there are none."""
        return next((stage for stage in self.stages[::-1] if MASS_FLUX in stage.writes), None)


def plan(stages: tuple[Stage, ...]) -> Plan:
    """Return the range of every stage, backwards from the fields that the last stage writes on the cells of a tile."""
    needed: dict[str, tuple[int, int]] = dict.fromkeys(stages[-1].writes, (0, 0))
    ranges: list[tuple[int, int]] = []
    for stage in reversed(stages):
        wanted = [needed.pop(name) for name in stage.writes if name in needed]
        low, high = min(r[0] for r in wanted), max(r[1] for r in wanted)
        ranges.append((low, high))
        if stage.sparse:
            needed |= dict.fromkeys(stage.writes, (low, high))
        for read in stage.reads.values():
            first, last = low + read.offsets[0], high + read.offsets[-1]
            old = needed.get(read.field, (first, last))
            needed[read.field] = (min(old[0], first), max(old[1], last))
    low, high = needed["q"]
    return Plan(stages, _with_guarded(stages, ranges[::-1]), max(-low, high))


def _with_guarded(stages: tuple[Stage, ...], ranges: list[tuple[int, int]]) -> tuple[tuple[int, int], ...]:
    """Extend a guarded stage to the full range of the fields that it overwrites.

    A stage before a guarded one covers as much as what it reads, where it reads nothing further away: it can then share
    the loop of the stage before it. So does a light stage, whose result is not stored anyway.
    """
    covered: dict[str, tuple[int, int]] = {}
    for k, stage in enumerate(stages):
        if stage.guard is not None:
            ranges[k] = covered[stage.writes[0]]
        elif stage.light or (k + 1 < len(stages) and stages[k + 1].guard is not None):
            wider = [covered[read.field] for read in stage.reads.values() if read.field in covered]
            if wider and all(read.here for read in stage.reads.values()):
                ranges[k] = max(low for low, _ in wider), min(high for _, high in wider)
        covered |= dict.fromkeys(stage.writes, ranges[k])
    return tuple(ranges)
