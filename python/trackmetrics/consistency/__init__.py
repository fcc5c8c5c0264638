"""Consistency of a filter: do its errors agree with its covariance?

| file | what it holds |
| --- | --- |
| `forms` | NEES and NIS |
| `chi_square` | the test of a mean, and the credibility interval, of pytcl |
| `averages` | means over runs, over time, over windows, and the scale they suggest |
| `correlation` | whiteness of innovations; NEES over time, where it is correlated |
| `credibility` | covariance and bias over runs; noncredibility and inclination |
| `distribution` | coverage, probability integral transform, proper scores |
| `subspace` | which states; the identity of an update |
"""

from trackmetrics import _deprecated
from trackmetrics.consistency.chi_square import consistency_test, credibility_interval
from trackmetrics.consistency.correlation_time import (
    correlation_time,
    decorrelated_nees,
    nees_correlation_time,
    nees_over_time,
)
from trackmetrics.consistency.coverage_and_pit import (
    coverage,
    coverage_curve,
    excess_nll,
    gaussian_crps,
    pit_test,
)
from trackmetrics.consistency.credibility import (
    bias_test,
    covariance_test,
    hotelling_test,
    inclination_index,
    noncredibility_index,
)
from trackmetrics.consistency.mean_tests import (
    anees,
    average_nis,
    covariance_scale,
    fading_memory_nis,
    moving_average_nis,
    normalized_mean_error,
)
from trackmetrics.consistency.nees_nis import average_nees, nees, nees_sequence, nis, nis_sequence
from trackmetrics.consistency.results import (
    CovarianceScale,
    Coverage,
    CredibilityIndex,
    DecorrelatedNEES,
    MeanTest,
    NormalizedMeanError,
    SignificanceTest,
    UniformityTest,
    UpdateIdentity,
    WhitenessTest,
)
from trackmetrics.consistency.subspace import marginal_nees, subspace_nees, update_identity
from trackmetrics.consistency.whiteness import whiteness, whiteness_across_runs

__all__ = [
    "CovarianceScale",
    "Coverage",
    "CredibilityIndex",
    "DecorrelatedNEES",
    "MeanTest",
    "NormalizedMeanError",
    "SignificanceTest",
    "UniformityTest",
    "UpdateIdentity",
    "WhitenessTest",
    "anees",
    "average_nees",
    "average_nis",
    "bias_test",
    "consistency_test",
    "correlation_time",
    "covariance_scale",
    "covariance_test",
    "coverage",
    "coverage_curve",
    "credibility_interval",
    "decorrelated_nees",
    "excess_nll",
    "fading_memory_nis",
    "gaussian_crps",
    "hotelling_test",
    "inclination_index",
    "marginal_nees",
    "moving_average_nis",
    "nees",
    "nees_correlation_time",
    "nees_over_time",
    "nees_sequence",
    "nis",
    "nis_sequence",
    "noncredibility_index",
    "normalized_mean_error",
    "pit_test",
    "subspace_nees",
    "update_identity",
    "whiteness",
    "whiteness_across_runs",
]

__getattr__ = _deprecated.module_getattr(__name__)
