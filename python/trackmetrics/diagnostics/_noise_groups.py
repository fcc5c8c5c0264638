"""The process noise of each group of states."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from trackmetrics.diagnostics._noise_fit import Floats, Integers
from trackmetrics.logs.log import EstimatorLog


def grouped(
    log: EstimatorLog, Q: Floats, process: str | Mapping[str, Sequence[str | int]], starts: Integers
) -> tuple[Floats, tuple[str, ...]]:
    """``(rows, groups, n, n)``: the process noise of each group of states, and their names."""
    Q = np.nan_to_num(Q)
    Q[starts[:-1]] = 0.0
    if process == "all":
        return Q[:, None], ("all",)
    names = log.state_names or tuple(f"x[{i}]" for i in range(Q.shape[1]))
    coupled = _coupled(Q)
    if process == "by_block":
        blocks = _blocks(coupled)
        return _split(Q, blocks), tuple(", ".join(names[i] for i in b) for b in blocks)
    if isinstance(process, str):
        raise ValueError(f"process must be 'all', 'by_block' or a dictionary, got {process!r}")
    blocks = [[_state(names, s) for s in states] for states in process.values()]
    _check_groups(blocks, coupled, names, tuple(process))
    return _split(Q, blocks), tuple(process)


def _state(names: Sequence[str], state: str | int) -> int:
    if isinstance(state, str):
        if state not in names:
            raise ValueError(f"process: no state {state!r}; the log has {', '.join(names)}")
        return names.index(state)
    return int(state)


def _coupled(Q: Floats) -> NDArray[np.bool_]:
    """Which states share process noise in any row."""
    d = np.sqrt(np.maximum(Q.diagonal(axis1=1, axis2=2), 1e-300))
    return np.asarray((np.abs(Q) > 1e-6 * d[:, :, None] * d[:, None, :]).any(axis=0))


def _blocks(coupled: NDArray[np.bool_]) -> list[list[int]]:
    """States that are connected by process noise; states without any are in no block."""
    reached = coupled | np.eye(len(coupled), dtype=bool)
    for _ in range(len(coupled)):
        reached = (reached.astype(int) @ reached.astype(int)) > 0
    driven = [i for i in range(len(coupled)) if coupled[i, i]]
    blocks = {tuple(np.flatnonzero(reached[i]).tolist()) for i in driven}
    return [list(block) for block in sorted(blocks)]


def _check_groups(
    blocks: list[list[int]], coupled: NDArray[np.bool_], names: Sequence[str], groups: Sequence[str]
) -> None:
    group_of: dict[int, int] = {}
    for g, block in enumerate(blocks):
        for state in block:
            if state in group_of:
                raise ValueError(f"process: state {names[state]!r} is in two groups")
            group_of[state] = g
    for i in range(len(coupled)):
        if coupled[i, i] and i not in group_of:
            raise ValueError(f"process: state {names[i]!r} has process noise and is in no group")
        for j in range(i):
            if coupled[i, j] and group_of.get(i) != group_of.get(j):
                raise ValueError(
                    f"process: states {names[j]!r} and {names[i]!r} share process noise "
                    "and must be in one group"
                )


def _split(Q: Floats, blocks: list[list[int]]) -> Floats:
    parts = np.zeros((len(Q), len(blocks), *Q.shape[1:]))
    for g, block in enumerate(blocks):
        index = np.ix_(range(len(Q)), block, block)
        parts[:, g][index] = Q[index]
    return parts
