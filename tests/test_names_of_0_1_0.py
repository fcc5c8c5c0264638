"""Every public name of release 0.1.0 still imports, with a warning if it is renamed."""

import subprocess
import sys
import warnings
from importlib import import_module

import pytest

from trackmetrics import _deprecated

NAMES = {
    "trackmetrics": """
        AuctionAssignment BottleneckAssignment ConsistencyResult CovarianceScale Coverage
        CredibilityIndex DecorrelatedNEES GOSPAResult GOSPASequence MOTMetrics Mahalanobis
        MeanTest NormalizedMeanError OSPA2Result OSPAResult SignificanceTest
        TrajectoryGOSPAResult UniformityTest UpdateIdentity Whiteness __version__ anees
        auction average_nees average_nis backend bias_test bottleneck_assignment
        calc_mospa_error consistency_test correlation_time covariance_scale
        covariance_test coverage coverage_curve credibility_interval decorrelated_nees
        estimation_error_bounds excess_nll fading_memory_nis gaussian_crps gospa
        gospa_from_distances gospa_over_time hotelling_test identity_switches
        inclination_index linear_sum_assignment linear_sum_assignment_batch marginal_nees
        mmospa2tar_2d mmospa_approx monte_carlo_rmse mot_metrics moving_average_nis nees
        nees_correlation_time nees_over_time nees_sequence nis nis_sequence
        noncredibility_index normalized_mean_error ospa ospa2 ospa_assignment
        ospa_from_distances ospa_over_time patch_pytcl pit_test position_rmse rmse
        set_threads subspace_nees threads track_fragmentation track_purity
        trajectory_gospa unpatch_pytcl update_identity use_backend velocity_rmse whiteness
        whiteness_across_runs
    """,
    "trackmetrics.accuracy": """
        estimation_error_bounds monte_carlo_rmse position_rmse rmse velocity_rmse
    """,
    "trackmetrics.assignment": """
        auction bottleneck_assignment linear_sum_assignment linear_sum_assignment_batch
    """,
    "trackmetrics.cli": """
        main
    """,
    "trackmetrics.compat": """
        patch_pytcl unpatch_pytcl
    """,
    "trackmetrics.consistency": """
        CovarianceScale Coverage CredibilityIndex DecorrelatedNEES MeanTest
        NormalizedMeanError SignificanceTest UniformityTest UpdateIdentity Whiteness anees
        average_nees average_nis bias_test consistency_test correlation_time
        covariance_scale covariance_test coverage coverage_curve credibility_interval
        decorrelated_nees excess_nll fading_memory_nis gaussian_crps hotelling_test
        inclination_index marginal_nees moving_average_nis nees nees_correlation_time
        nees_over_time nees_sequence nis nis_sequence noncredibility_index
        normalized_mean_error pit_test subspace_nees update_identity whiteness
        whiteness_across_runs
    """,
    "trackmetrics.diagnostics": """
        Bias Diagnosis EstimatorLog LiveMonitor LiveStatus Outlier QuantityVerdict Segment
        State StateDiagnosis TrackDiagnosis VERDICTS Whiteness diagnose read_log
    """,
    "trackmetrics.estimation_metrics": """
        ConsistencyResult average_nees consistency_test credibility_interval
        estimation_error_bounds monte_carlo_rmse nees nees_sequence nis nis_sequence
        position_rmse rmse velocity_rmse
    """,
    "trackmetrics.io": """
        Boxes read_mot_challenge
    """,
    "trackmetrics.io.mot_challenge": """
        Boxes read_mot_challenge
    """,
    "trackmetrics.monte_carlo": """
        Accumulator Best ConsistencyAccumulator ConsistencySummary Failure FormStatistics
        LabelAccumulator LabelSummary PointSetAccumulator PointSetSummary ScoreAccumulator
        SweepInterrupted SweepResult sweep
    """,
    "trackmetrics.mospa": """
        calc_mospa_error mmospa2tar_2d mmospa_approx
    """,
    "trackmetrics.point_sets": """
        Mahalanobis gospa gospa_from_distances gospa_over_time ospa ospa_assignment
        ospa_from_distances ospa_over_time
    """,
    "trackmetrics.report": """
        comparison_figure coverage_figure gospa_figure ospa_figure overview_figure page
        rmse_figure track_figure write_page
    """,
    "trackmetrics.report.sweep_page": """
        write_sweep_page
    """,
    "trackmetrics.report.sweeps": """
        heat_figure sweep_figure
    """,
    "trackmetrics.results": """
        AuctionAssignment BottleneckAssignment ConsistencyResult GOSPAResult GOSPASequence
        MOTMetrics OSPA2Result OSPAResult TrajectoryGOSPAResult
    """,
    "trackmetrics.track_metrics": """
        MOTMetrics OSPAResult identity_switches mot_metrics ospa ospa_over_time
        track_fragmentation track_purity
    """,
    "trackmetrics.tracking": """
        identity_switches mot_metrics track_fragmentation track_purity
    """,
    "trackmetrics.trajectories": """
        ospa2 trajectory_gospa
    """,
    "trackmetrics.vessel": """
        HeldOut KINDS Noise Recording Reports STATES SetAside Settings Ship Simulation
        THREE_SHIPS Tracker Turn VesselTrack decimated fleet predictive_nis read_ais
        screen simulate three_ships
    """,
}
CASES = [(module, name) for module, names in NAMES.items() for name in names.split()]


@pytest.mark.parametrize(("module", "name"), CASES)
def test_a_name_imports(module, name):
    is_renamed = f"{module}.{name}" in _deprecated.RENAMED
    found = import_module(module)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        getattr(found, name)
    assert [w.category for w in caught] == [DeprecationWarning] * is_renamed


STAR = {
    "trackmetrics": "ospa nees nis rmse gospa",
    "trackmetrics.diagnostics": "EstimatorLog State read_log diagnose",
    "trackmetrics.io": "Boxes read_mot_challenge",
}


@pytest.mark.parametrize("module", STAR)
def test_everything_at_once(module):
    script = f"from {module} import *\n" + "\n".join(STAR[module].split())
    command = [sys.executable, "-W", "ignore", "-c", script]
    subprocess.run(command, check=True)
