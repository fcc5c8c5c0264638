"""Noises that change in time: a manoeuvre, or a sensor that is worse in a part of the track."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from trackmetrics.diagnostics._noise_baseline import Baseline, Fault
from trackmetrics.diagnostics._noise_fit import NEAR, ErrorModel, Fit, Floats, Integers, maximise

BLOCKS = 10
"""Into so many parts a track is cut when a change in time is sought."""
CHUNK = 20_000
"""How many updates are looked at together for a change in time."""


def changes(base: Baseline) -> Iterator[Fault]:
    """Process noise, or noise of one measurement type, with another factor in a part of the track:
    of the part with the largest score."""
    model = base.model
    blocks = _blocks(model)
    most = int(blocks.max()) + 1
    if most < 3:
        return
    gradient, information = _scores_by_block(model, base.fit, blocks, most)
    groups = len(model.process)
    whole: Floats = np.kron(np.eye(model.count), np.ones((most, 1))).astype(np.float64)
    choices = most * (most + 1) // 2
    kinds = [tuple(range(groups))] + [(groups + t,) for t in range(len(model.measurement))]
    for kind in kinds:
        window = _best_window(gradient, information, whole, kind, most)
        if window is None:
            continue
        rows = (blocks >= window[0]) & (blocks < window[1])
        yield _change(base, rows, kind, window, most, choices * len(kinds) / 3)


def _blocks(model: ErrorModel) -> Integers:
    """The part of its track to which each row belongs."""
    lengths = np.diff(model.starts)
    most = int(np.clip(lengths.max() // 5, 1, BLOCKS))
    parts = [np.arange(length) * most // max(length, 1) for length in lengths]
    return np.concatenate(parts)


def _scores_by_block(
    model: ErrorModel, fit: Fit, blocks: Integers, most: int
) -> tuple[Floats, Floats]:
    """Score and information of each factor in each part, over some tracks at a time: every part
    needs process noises of its own."""
    factors = np.repeat(fit.factors, most)
    gradient, information = np.zeros(len(factors)), np.zeros((len(factors), len(factors)))
    first = 0
    while first < len(model.starts) - 1:
        last = int(np.searchsorted(model.starts, model.starts[first] + CHUNK, "right")) - 1
        last = max(last, first + 1)
        rows = slice(int(model.starts[first]), int(model.starts[last]))
        split = _by_block(model.tracks(first, last), blocks[rows], most)
        _, gradients, informations = split.evaluate(factors)[:3]
        gradient += gradients.sum(0)[:-1]
        information += informations.sum(0)[:-1, :-1]
        first = last
    return gradient, information


def _by_block(model: ErrorModel, blocks: Integers, most: int) -> ErrorModel:
    """The model with each factor once for each part of the tracks."""
    own = (blocks[:, None] == np.arange(most)).astype(float)
    Q = (model.Q[:, :, None] * own[:, None, :, None, None]).reshape(
        len(blocks), -1, *model.Q.shape[2:]
    )
    names = tuple(f"{name} {b}" for name in model.process for b in range(most))
    types = model.types * most + blocks
    kinds = tuple(f"{name} {b}" for name in model.measurement for b in range(most))
    return replace(model, Q=Q, process=names, types=types, measurement=kinds)


def _best_window(
    gradient: Floats, information: Floats, whole: Floats, kind: tuple[int, ...], most: int
) -> tuple[int, int] | None:
    """The part with the largest score of another factor in it, the factors of all being free."""
    best, found = 0.0, None
    base = whole.T @ information @ whole + 1e-12 * np.eye(whole.shape[1])
    for a in range(most):
        for b in range(a + 1, most + 1):
            if b - a == most:
                continue
            w = np.zeros(len(gradient))
            for k in kind:
                w[k * most + a : k * most + b] = 1.0
            shared = whole.T @ information @ w
            own = float(w @ information @ w - shared @ np.linalg.solve(base, shared))
            if own > 1e-9 * (w @ information @ w):
                score = abs(float(w @ gradient)) / own**0.5
                if score > best:
                    best, found = score, (a, b)
    return found


def _change(
    base: Baseline, rows: NDArray[np.bool_], kind: tuple[int, ...], window: tuple[int, int],
    most: int, choices: float,
) -> Fault:  # fmt: skip
    model, groups = base.model, len(base.model.process)
    process = kind[0] < groups
    if process:
        total = model.Q.sum(axis=1, keepdims=True) * rows[:, None, None, None]
        Q = np.concatenate([model.Q * ~rows[:, None, None, None], total], axis=1)
        changed = replace(model, Q=Q, process=(*model.process, "changed"))
        place = groups
    else:
        types = np.where(
            rows & (model.types == kind[0] - groups), model.count - groups, model.types
        )
        changed = replace(model, types=types, measurement=(*model.measurement, "changed"))
        place = model.count
    start = np.insert(base.fit.factors, place, base.fit.factors[kind[0]])
    found = maximise(changed, start, tolerance=NEAR)
    ones = np.ones(changed.count)
    fixed = [i for i in range(changed.count) if i != place]
    alone = maximise(changed, ones, fixed, NEAR)
    part = f"{100 * window[0] // most} to {100 * window[1] // most} % of the track"
    if process:
        ratio = found.factors[place] / max(found.factors[0], 1e-9)
        more = "more" if ratio > 1 else "less"
        detail = f"the target moves {more} than elsewhere at {part}"
        reason = "manoeuvre"
    else:
        name = model.measurement[kind[0] - groups]
        detail = f"the noise of {name} differs at {part}"
        reason = "changing noise"
    return base.fault(reason, detail, alone.value, found.value, 1, choices)
