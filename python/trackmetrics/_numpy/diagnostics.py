"""Changes of scale and attribution to states: reference of ``diagnostics`` in the core."""

from itertools import pairwise
from math import factorial

import numpy as np
from numpy.typing import NDArray

from trackmetrics import errors as messages
from trackmetrics._numpy.arguments import Floats, plain, plain_ids

Integers = NDArray[np.int64]

FINE = 1024
MOST_STATES = 16
FORGOTTEN, LONGEST = 1e-4, 200


def scale_partitions(
    values: Floats, dof: Floats, starts: Integers, least: int, most: int
) -> tuple[Floats, Integers]:
    """The best partitions of many sequences: gains ``(k, most)`` and cuts ``(k, most, most - 1)``.

    Dynamic programming over the best place of the last cut; see the core for the objective.
    """
    plain(values, dof)
    plain_ids(starts)
    _check_values(values, dof)
    _check_starts("values", starts, len(values))
    for argument, count in (("least", least), ("most", most)):
        if count == 0:
            raise messages.parameter(argument, "at least 1", 0.0)
    gains = np.full((len(starts) - 1, most), -np.inf)
    cuts = np.full((len(starts) - 1, most, most - 1), -1, np.int64)
    for i, (a, b) in enumerate(pairwise(starts)):
        for s, (gain, places) in enumerate(_partition(values[a:b], dof[a:b], least, most)):
            gains[i, s] = gain
            cuts[i, s, : len(places)] = places
    return gains, cuts


def best_split_gains(draws: Floats, dof: Floats, least: int) -> Floats:
    """The gain of the best cut of each row of draws."""
    plain(draws, dof)
    if not np.isfinite(draws).all():
        i = int(np.argmin(np.isfinite(draws.ravel())))
        raise messages.not_finite("draws", [i], draws.ravel()[i])
    for m in dof[~(np.isfinite(dof) & (dof > 0))]:
        raise messages.parameter("dof", "positive", m)
    n = len(dof)
    if draws.shape[1] != n:
        raise messages.length("draws", draws.size, "dof", n, "values")
    least = max(least, 1)
    if n < 2 * least:
        return np.zeros(len(draws) if n else 0)
    sums, dofs = np.cumsum(draws, axis=1), np.cumsum(dof)
    left, m = sums[:, least - 1 : n - least], dofs[least - 1 : n - least]
    total, all_dof = sums[:, -1:], dofs[-1]
    gains: Floats = (_best(left, m) + _best(total - left, all_dof - m)).max(axis=1)
    return gains - _best(total, all_dof)[:, 0]


def first_alarms(
    values: Floats, dof: Floats, starts: Integers, scale: float, alpha: float
) -> Integers:
    """Where a cumulative sum of log-likelihood ratios first passes its threshold, and began to.

    For each sequence the alarm and the last lowest sum before it; -1 where there is no alarm.
    """
    plain(values, dof)
    plain_ids(starts)
    _check_values(values, dof)
    _check_starts("values", starts, len(values))
    for argument, value in (("scale", scale), ("alpha", alpha)):
        if not (value > 0 and np.isfinite(value)):
            raise messages.parameter(argument, "positive", value)
    rises = values * ((1 - 1 / scale) / 2) - dof * (np.log(scale) / 2)
    found = np.full((len(starts) - 1, 2), -1, np.int64)
    for alarm, (a, b) in zip(found, pairwise(starts), strict=True):
        sums = np.concatenate([[0.0], np.cumsum(rises[a:b])])
        lowest = np.minimum.accumulate(sums)
        above = np.flatnonzero(sums - lowest > np.log(max(b - a, 1) / alpha))
        if len(above):
            k = above[0] - 1
            alarm[:] = k, np.flatnonzero(sums[: k + 1] == lowest[k])[-1]
    return found


def shapley_shares(errors: Floats, covariances: Floats) -> Floats:
    """The Shapley split of many squared errors over the states, from every coalition's worth."""
    plain(errors, covariances)
    d = errors.shape[1]
    if d > MOST_STATES:
        raise messages.parameter("dimension", "at most 16", d)
    _check_matrices(errors, covariances)
    worth = np.zeros((len(errors), 1 << d))
    for coalition in range(1, 1 << d):
        worth[:, coalition] = _worth(errors, covariances, _members(coalition, d))
    shares = np.zeros_like(errors)
    for coalition in range(1 << d):
        size = coalition.bit_count()
        for state in set(range(d)) - set(_members(coalition, d)):
            weight = factorial(size) * factorial(d - size - 1) / factorial(d)
            shares[:, state] += weight * (worth[:, coalition | 1 << state] - worth[:, coalition])
    return shares


def sampled_shapley_shares(errors: Floats, covariances: Floats, orders: Integers) -> Floats:
    """The same as a mean over given orders of the states.

    A state adds the square of its error, whitened against the states before it.
    """
    plain(errors, covariances)
    plain_ids(orders)
    d = errors.shape[1]
    rows = _permutations(orders, d)
    _check_matrices(errors, covariances)
    shares = np.zeros_like(errors)
    for order in rows:
        factor = _factors(covariances[:, order][:, :, order])
        shares[:, order] += np.linalg.solve(factor, errors[:, order, None])[..., 0] ** 2
    return shares / len(rows)


def nees_inflation(
    transitions: Floats, covariances: Floats, starts: Integers, known: Integers | None
) -> Floats:
    """By how much correlation in time widens each NEES of many tracks.

    Where only some components of an error are ``known`` (1, else 0), the correlation of all is seen
    through the basis of these.
    """
    plain(transitions, covariances)
    plain_ids(starts, *([] if known is None else [known]))
    if len(transitions) != len(covariances):
        found, expected = len(transitions), len(covariances)
        raise messages.length("transitions", found, "covariances", expected, "matrices")
    for argument, values in (("transitions", transitions), ("covariances", covariances)):
        _check_finite(argument, values)
    _check_starts("covariances", starts, len(covariances))
    d = covariances.shape[1]
    if known is not None and len(known) != len(covariances) * d:
        expected = len(covariances) * d
        raise messages.length("known", len(known), "covariances", expected, "components")
    factors = _factors(covariances)
    views = _views(factors, known)
    tau = np.ones(len(covariances))
    for a, b in pairwise(starts):
        steps = [
            np.linalg.solve(factors[k], transitions[k] @ factors[k - 1]) for k in range(a + 1, b)
        ]
        for k in range(1, len(steps) + 1):
            product = np.eye(d)
            for step in range(k - 1, max(k - 1 - LONGEST, -1), -1):
                product = product @ steps[step]
                if (product**2).sum() < FORGOTTEN:
                    break
                left, right = views[a + k], views[a + step]
                shared = float(((left @ product @ right.T) ** 2).sum())
                tau[a + k] += shared / max(len(left), 1)
                tau[a + step] += shared / max(len(right), 1)
    return tau


def _views(factors: Floats, known: Integers | None) -> list[Floats]:
    """Of each error's whitened components a basis of those that tell the known ones."""
    d = factors.shape[1]
    if known is None:
        return [np.eye(d)] * len(factors)
    rows = [f[k] for f, k in zip(factors, known.reshape(-1, d) != 0, strict=True)]
    return [np.linalg.solve(np.linalg.cholesky(row @ row.T), row) for row in rows]


def _best(sums: Floats, dof: Floats) -> Floats:
    """-M ln(N / M): twice the best log-likelihood of a segment, up to terms of the data alone."""
    likelihood: Floats = -dof * np.log(np.maximum(sums / dof, 1e-12))
    return likelihood


def _partition(values: Floats, dof: Floats, least: int, most: int) -> list[tuple[float, list[int]]]:
    stride = max(1, -(-len(values) // FINE))
    if stride == 1:
        return _optimal(values, dof, least, most)
    edges = np.arange(len(values) // stride) * stride
    coarse = [np.add.reduceat(column, edges) for column in (values, dof)]
    found = _optimal(coarse[0], coarse[1], -(-least // stride), most)
    refined: list[tuple[float, list[int]]] = []
    for gain, places in found:
        cuts = [place * stride for place in places]
        refined.append((_refine(values, dof, least, stride, cuts) if cuts else gain, cuts))
    return refined


def _refine(values: Floats, dof: Floats, least: int, stride: int, cuts: list[int]) -> float:
    """Moves each cut, twice in turn, to the best place within a stride; the gain after that."""
    n = len(values)
    for _ in range(2):
        for j in range(len(cuts)):
            before, after = [0, *cuts][j], [*cuts, n][j + 1]
            low, high = max(cuts[j] - stride, before + least), min(cuts[j] + stride, after - least)
            if low <= high:
                places = np.arange(low, high + 1)
                left = _sums(values, dof, before, places)
                right = _sums(values, dof, places, after)
                cuts[j] = int(places[np.argmax(_best(*left) + _best(*right))])
    edges = [0, *cuts, n]
    return float(
        sum(_best(values[a:b].sum(), dof[a:b].sum()) for a, b in pairwise(edges))
        - _best(values.sum(), dof.sum())
    )


def _sums(
    values: Floats, dof: Floats, a: int | Integers, b: int | Integers
) -> tuple[Floats, Floats]:
    sums, dofs = (np.concatenate([[0.0], np.cumsum(column)]) for column in (values, dof))
    return sums[b] - sums[a], dofs[b] - dofs[a]


def _optimal(values: Floats, dof: Floats, least: int, most: int) -> list[tuple[float, list[int]]]:
    n = len(values)
    best = np.full((most, n + 1), -np.inf)
    came_from = np.zeros((most, n + 1), np.int64)
    for end in range(max(least, 1), n + 1):
        begins = end - least + 1
        # Summed from the end, so that a huge value far back does not swallow small ones.
        sums = np.cumsum(values[:end][::-1])[::-1][:begins]
        row = _best(sums, np.cumsum(dof[:end][::-1])[::-1][:begins])
        best[0, end] = row[0]
        for s in range(1, most):
            total = best[s - 1, :begins] + row
            came_from[s, end] = np.argmax(total)
            best[s, end] = total[came_from[s, end]]
    found: list[tuple[float, list[int]]] = []
    for s in range(most):
        if s == 0 or not n >= (s + 1) * least:
            found.append((0.0 if s == 0 else -np.inf, []))
            continue
        cuts = [n]
        for level in range(s, 0, -1):
            cuts.append(int(came_from[level, cuts[-1]]))
        found.append((float(best[s, n] - best[0, n]), cuts[:0:-1]))
    return found


def _members(coalition: int, d: int) -> list[int]:
    return [state for state in range(d) if coalition >> state & 1]


def _worth(e: Floats, p: Floats, members: list[int]) -> Floats:
    whitened = np.linalg.solve(_factors(p[:, members][:, :, members]), e[:, members, None])
    worth: Floats = (whitened[..., 0] ** 2).sum(axis=1)
    return worth


def _factors(covariances: Floats) -> Floats:
    """Cholesky factors; the first covariance that has none is named, with its leading minor."""
    try:
        factors: Floats = np.linalg.cholesky(covariances).astype(np.float64)
        return factors
    except np.linalg.LinAlgError:
        for k, matrix in enumerate(covariances):
            for minor in range(1, len(matrix) + 1):
                try:
                    np.linalg.cholesky(matrix[:minor, :minor])
                except np.linalg.LinAlgError:
                    raise messages.not_positive_definite("covariances", [k], minor) from None
        raise


def _permutations(orders: Integers, d: int) -> Integers:
    if d == 0 or orders.size == 0 or orders.size % d:
        raise messages.parameter(
            "orders", "permutations of the states", orders[0] if orders.size else 0
        )
    for row in orders.reshape(-1, d):
        for k, state in enumerate(row):
            if not 0 <= state < d or state in row[:k]:
                raise messages.parameter("orders", "permutations of the states", state)
    rows: Integers = orders.reshape(-1, d)
    return rows


def _check_matrices(e: Floats, p: Floats) -> None:
    if p.shape != (len(e), e.shape[1], e.shape[1]):
        found = p.size // max(e.shape[1] ** 2, 1)
        raise messages.length("covariances", found, "errors", len(e), "matrices")
    _check_finite("errors", e)
    _check_finite("covariances", p)


def _check_finite(argument: str, values: Floats) -> None:
    if not np.isfinite(values).all():
        index = np.argwhere(~np.isfinite(values))[0]
        raise messages.not_finite(argument, [int(index[0])], values[tuple(index)])


def _check_values(values: Floats, dof: Floats) -> None:
    if len(dof) != len(values):
        raise messages.length("dof", len(dof), "values", len(values), "values")
    good = np.isfinite(values) & (values >= 0) & np.isfinite(dof) & (dof > 0)
    if good.all():
        return
    i = int(np.argmin(good))
    for argument, value, needed in (
        ("values", values[i], "at least 0"),
        ("dof", dof[i], "positive"),
    ):
        if not np.isfinite(value):
            raise messages.not_finite(argument, [i], value)
        if value < 0 or (argument == "dof" and value == 0):
            raise messages.parameter(argument, needed, value)


def _check_starts(argument: str, starts: Integers, count: int) -> None:
    if not len(starts) or starts[0] != 0 or starts[-1] != count or (np.diff(starts) < 0).any():
        raise messages.offsets(argument, count)
