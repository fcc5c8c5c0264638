"""A log refuses the covariances that the NIS refuses, and accepts the others."""

import numpy as np
import pytest

import trackmetrics
from trackmetrics.logs import EstimatorLog

EPS = np.finfo(float).eps
SCALED = np.diag([1e-12, 1e12]) + 0.5 * np.array([[0.0, 1.0], [1.0, 0.0]])
CASES = {
    "singular": [[1.0, 1.0], [1.0, 1.0]],
    "singular but for rounding": [[1.0, 1.0], [1.0, 1.0 + EPS]],
    "nearly singular": [[1.0, 1.0], [1.0, 1.0 + 16 * EPS]],
    "of very different scales": SCALED,
    "a little asymmetric": [[1.0, 0.5], [0.5 + 1e-9, 1.0]],
    "asymmetric": [[1.0, 0.5], [0.5 + 1e-7, 1.0]],
    "indefinite": [[1.0, 2.0], [2.0, 1.0]],
}


ACCEPTED = ("nearly singular", "of very different scales", "a little asymmetric")


def refusal(call):
    """What the message says after the name of the argument; nothing where there is none."""
    try:
        call()
    except ValueError as error:  # of which LinAlgError is one
        return str(error).partition(" is ")[2]
    return ""


@pytest.mark.parametrize("backend", ["native", "numpy"])
@pytest.mark.parametrize("case", CASES)
def test_a_log_has_the_rule_of_nis(case, backend):
    S, v = np.array(CASES[case]), np.ones(2)
    with trackmetrics.use_backend(backend):
        by_nis = refusal(lambda: trackmetrics.nis(v, S))
        by_log = refusal(
            lambda: EstimatorLog.from_columns(time=[0.0], innovation=v[None], S=S[None])
        )
    assert (by_nis == "") == (by_log == "") == (case in ACCEPTED)
    assert by_log[:21] == by_nis[:21]
