"""A fault as a model of its own, compared with the claimed noises and with the best factors.

A fault is judged twice: beside the claimed noises alone, where it competes with the factors for the
better explanation (by the Bayesian information criterion), and beside the best factors, where its
likelihood ratio says whether these leave something unexplained.
"""

from dataclasses import dataclass, replace
from math import log

import numpy as np

from trackmetrics.diagnostics._noise_fit import ErrorModel, Fit, Floats, chi_square_tail


@dataclass(frozen=True)
class Fault:
    """A fault, and how much better the log is explained with it."""

    reason: str
    """``"bias"``, ``"outliers"``, ``"manoeuvre"``, ``"correlated noise"`` or
    ``"changing noise"``."""
    detail: str
    """What is known of it."""
    gain: float
    """Twice the log-likelihood that it adds to the claimed noises, less what its parameters cost
    by the Bayesian information criterion."""
    p_value: float
    """Probability of so large a gain over the best factors if there is no such fault."""


@dataclass(frozen=True)
class Baseline:
    """The claims and the best factors, that every fault is compared with."""

    model: ErrorModel
    claimed: float
    """Log-likelihood of the claimed noises."""
    fit: Fit

    @property
    def size(self) -> float:
        """How many components of innovations there are."""
        return float((~np.isnan(self.model.innovations)).sum())

    def fault(
        self,
        reason: str,
        detail: str,
        claimed: float,
        fitted: float,
        dof: int,
        choices: float,
    ) -> Fault:
        """A fault of so many parameters, the best of so many that were tried."""
        gain = 2 * (claimed - self.claimed) - dof * log(self.size) - 2 * log(choices)
        statistic = 2 * (fitted - self.fit.value)
        p_value = min(1.0, choices * chi_square_tail(statistic, dof))
        return Fault(reason, detail, gain, p_value)


def augmented(model: ErrorModel, H: Floats, F: Floats, Q: Floats, initial: Floats) -> ErrorModel:
    """The model with further states, that move by ``F`` with noise ``Q`` (which the last group of
    process noise holds); ``F`` and ``Q`` of all rows, or one of each row."""
    rows, n, e = len(model.H), model.H.shape[2], H.shape[2]
    larger = np.zeros((rows, n + e, n + e))
    larger[:, :n, :n], larger[:, n:, n:] = model.F, F
    groups = model.Q.shape[1]
    noises = np.zeros((rows, groups, n + e, n + e))
    noises[:, :, :n, :n] = model.Q
    if np.any(Q):
        extra = np.zeros((rows, 1, n + e, n + e))
        extra[:, 0, n:, n:] = Q
        noises = np.concatenate([noises, extra], axis=1)
    start = np.zeros((len(model.initial), n + e, n + e))
    start[:, :n, :n], start[:, n:, n:] = model.initial, initial
    corrections = np.pad(model.corrections, [(0, 0), (0, e)])
    return replace(
        model, H=np.concatenate([model.H, H], axis=2), F=larger, Q=noises, initial=start,
        corrections=corrections,
        process=model.process + (("added",) if np.any(Q) else ()),
    )  # fmt: skip
