"""Fingerprints of short runs on random scenes: a change of any number in a model, solver, scheme or source shows in one of them.

They say that numbers changed, not which are right. After a change that was meant::

    python -m tests.granular.fingerprints            # what differs, by how much
    python -m tests.granular.fingerprints --write    # keep what is computed now
"""

import argparse
import json
from pathlib import Path

import attrs
import numpy as np

from fvkit import Stepper
from tests.tools.random_draws import CELLS, random_scene
from tests.tools.random_runs import HIGH, MODELS, pairs, scheme_of

FILE = Path(__file__).with_name("fingerprints.json")
SEED, SCENES = 20, 8
STEPS = {1: 10, 2: 10, HIGH: 1}
CASES = [(model, riemann, order) for model, riemann in pairs() for order in STEPS]

#: Weights of the cells in a sum that stands for a row: none alike.
WEIGHTS = np.cos(np.arange(CELLS) ** 2.0)

#: How far a sum may be from the one that is kept, relative to its terms: processors and NumPy differ by less.
TOLERANCE = 1e-9


def scene_of(index, order):
    scene = random_scene(SEED, index)
    return attrs.evolve(scene, nu=None) if order == HIGH else scene


def fingerprint(model, riemann, order, scene, backend="numpy"):
    """Return the time, the faces that lost hyperbolicity, the weighted sum of each row and what passed both ends, and the scale of each."""
    stepper = Stepper(scene.problem(MODELS[model]), scheme_of(riemann, order), nonhyperbolic="ignore", backend=backend)
    stepper.run(stepper.problem.t_end, STEPS[order])
    terms, passed = WEIGHTS * stepper.q, stepper.snapshot()["masses"][:2].ravel()
    masses = [np.abs(terms[row]).sum() for row in stepper.problem.model.mass_rows()]
    return (np.array([stepper.t, stepper.stats().nonhyperbolic_faces, *terms.sum(axis=1), *passed]),
            np.array([stepper.t, 1.0, *np.abs(terms).sum(axis=1), *(np.abs(passed) + 1e-3 * np.array(2 * masses))]))


def distance(found, kept):
    """Return the largest difference of a fingerprint from numbers that were kept, relative to its terms."""
    numbers, scale = found
    return float(np.max(np.abs(numbers - kept) / np.maximum(scale, 1e-300)))


def steady(model, riemann, order, scene):
    """Whether a scene's fingerprint does not hang on the last digits of its data."""
    kept = fingerprint(model, riemann, order, scene)[0]
    for seed in range(4):
        noise = 1.0 + 2.0**-52 * np.random.default_rng(seed).integers(-8, 9, (3, CELLS))
        h, phi, vs, vf = scene.flow
        other = attrs.evolve(scene, flow=(h * noise[0], phi, vs * noise[1], vf * noise[2]))
        if distance(fingerprint(model, riemann, order, other), kept) > 1e-2 * TOLERANCE:
            return False
    return True


def chosen(number, case):
    """Return the fingerprints of a case by the index of the scene; which ones differs from case to case."""
    kept = {}
    index = number
    while len(kept) < SCENES:
        scene = scene_of(index, case[2])
        if steady(*case, scene):
            kept[str(index)] = fingerprint(*case, scene)[0].tolist()
        index += 37  # through classes, settings and bottoms
    return kept


def label(case):
    return "{} {} {}".format(*case)


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.granular.fingerprints")
    parser.add_argument("--write", action="store_true", help="keep what is computed now")
    if parser.parse_args().write:
        lines = [f"{json.dumps(label(case))}: {json.dumps(chosen(number, case))}" for number, case in enumerate(CASES)]
        FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
        return
    kept = json.loads(FILE.read_text(encoding="utf-8"))
    for case in CASES:
        for index, values in kept[label(case)].items():
            far = distance(fingerprint(*case, scene_of(int(index), case[2])), np.array(values))
            if far > TOLERANCE:
                print(f"{label(case)}, scene {index}: {far:.1e}")


if __name__ == "__main__":
    main()
