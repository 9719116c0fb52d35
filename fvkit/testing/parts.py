"""`LimiterConformance` and `SourceConformance`."""

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fvkit import Limiter, Model, Source
from fvkit.testing.common import OnModel, Suite, check_is_data, close, need, rows


class LimiterConformance(Suite):
    """Conformance checks of a limiter.

    Attributes
    ----------
    limiter : the limiter.
    monotone : whether phi lies in Sweby's region, 0 <= phi <= min(2, 2 theta): no new extrema.

    Examples
    --------
    >>> import fvkit as fv
    >>> from fvkit.testing import LimiterConformance, run
    >>> class TestMC(LimiterConformance):
    ...     limiter = fv.MC()
    >>> print(run(TestMC))
    4 checks passed, 0 skipped
    """

    kinds: ClassVar[Mapping[str, type]] = {"limiter": Limiter}

    limiter: ClassVar[Limiter]
    monotone: ClassVar[bool] = True

    def phi(self, theta: Any, nu: float = 0.5) -> np.ndarray:
        """Values of the limiter."""
        theta = np.asarray(theta, dtype=float)
        return np.broadcast_to(self.limiter.phi(theta, np.full_like(theta, nu)), theta.shape)

    def test_it_is_data(self) -> None:
        check_is_data(self.limiter)

    def test_linear_data_are_left_alone(self) -> None:
        for nu in (0.0, 0.3, 0.9):
            np.testing.assert_allclose(self.phi([1.0], nu), 1.0, rtol=1e-14)

    def test_it_is_bounded(self) -> None:
        assert np.isfinite(self.phi([-1e300, -1.0, 0.0, 1.0, 1e300])).all()

    def test_it_lies_in_the_region_without_new_extrema(self) -> None:
        if not self.monotone:
            pytest.skip(f"{type(self.limiter).__name__} is said not to be monotone")
        theta = np.linspace(-3.0, 6.0, 1001)
        phi = self.phi(theta)
        assert (phi >= 0.0).all()
        assert (phi <= np.minimum(2.0, np.maximum(2.0 * theta, 0.0)) + 1e-14).all()


class SourceConformance(OnModel):
    """Conformance checks of a source on one model.

    Attributes
    ----------
    source : the source.
    model : a model that it acts on.
    accuracy : relative tolerance of ``step`` against the integrated ``rate``.
    dt : time of the comparison, s.
    of_mass : whether the source changes masses.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> from fvkit.testing import SourceConformance
    >>> class TestDrag(SourceConformance):
    ...     source, model = gr.ConstantDrag(D=5.0), gr.TwoPhase(dry=1e-8)
    ...     def states(self, rng, count):
    ...         return rng.uniform(0.5, 1.0, (4, count))
    >>> TestDrag().test_the_step_follows_the_rate()  # pytest calls every check, fvkit.testing.run too
    """

    kinds: ClassVar[Mapping[str, type]] = {"model": Model, "source": Source}

    source: ClassVar[Source]
    accuracy: ClassVar[float] = 1e-6
    dt: ClassVar[float] = 0.1
    of_mass: ClassVar[bool] = False

    def drawn(self, count: int = 20) -> tuple[Model, np.ndarray, tuple[np.ndarray, ...]]:
        """The model, random states, and aux values."""
        q = self.random(np.random.default_rng(1), count)
        return self.model.resolved(q), q, tuple(np.zeros((len(self.model.aux), count)))

    def after(self, dt: float) -> np.ndarray:
        """States after dt."""
        model, q, aux = self.drawn()
        return rows(self.source.step(model, tuple(q), aux, dt), q.shape[1])

    def test_it_serves_the_model(self) -> None:
        self.source.check(self.model)

    def test_no_time_changes_nothing(self) -> None:
        close(self.after(0.0), self.drawn()[1], 1e-14)

    def test_masses_stay(self) -> None:
        _, q, _ = self.drawn()
        for row in self.model.mass_rows():
            if self.of_mass:
                assert (self.after(1e6)[row] >= 0.0).all()
            else:
                np.testing.assert_array_equal(self.after(self.dt)[row], q[row])

    def test_any_time_leaves_a_number(self) -> None:
        for dt in (1e-12, 1.0, 1e6, 1e12):
            assert np.isfinite(self.after(dt)).all(), dt

    def test_the_step_follows_the_rate(self) -> None:
        model, q, aux = self.drawn()
        end = self.after(self.dt)
        for cell in range(q.shape[1]):
            given = tuple(values[cell:cell + 1] for values in aux)

            def rate(_: float, state: np.ndarray, given: Any = given) -> np.ndarray:
                return rows(self.source.rate(model, tuple(state[:, None]), given), 1)[:, 0]

            exact = solve_ivp(rate, (0.0, self.dt), q[:, cell], method="LSODA", rtol=1e-10, atol=1e-13).y[:, -1]
            close(end[:, cell:cell + 1], exact[:, None], self.accuracy)

    def test_an_implicit_stage_solves_its_equation(self) -> None:
        need(self.source, "implicit_rate")
        model, q, aux = self.drawn()
        rate = rows(self.source.implicit_rate(model, tuple(q), aux, self.dt), q.shape[1])
        there = rows(self.source.rate(model, tuple(q + self.dt * rate), aux), q.shape[1])
        close(rate, there, 1e-8, np.abs(q).max(axis=0))
