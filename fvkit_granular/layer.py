"""What the models of this package share about their thresholds."""

from typing import Any

import attrs
import numpy as np

from fvkit_granular.bed import LEAST_DRY

#: Default threshold of a dry cell, as a share of the largest initial depth.
DRY_SHARE = 1e-8

DRY_HINT = "depth in metres below which a film does not move; None for 1e-8 of the largest initial depth"


def resolved(model: Any, q0: np.ndarray) -> Any:
    """Return the model with its ``dry``, where it is None, set to fit the initial state."""
    if model.dry is not None:
        return model
    largest = float(q0[[row for masses, _ in model.phases for row in masses]].sum(axis=0).max())
    return attrs.evolve(model, dry=max(DRY_SHARE * largest, LEAST_DRY))
