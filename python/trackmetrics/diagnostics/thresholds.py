"""Every threshold of the diagnosis, once, named for what it limits."""

# -- false alarms

ALPHA = 0.004
"""Default false-alarm probability of each family of tests."""
MAX_ALPHA = 0.05
"""Largest false-alarm probability that :func:`diagnose` accepts."""

# -- sizes

MIN_UPDATES_TO_JUDGE = 4
"""Fewest values that a verdict is made from."""
MIN_DOF_TO_JUDGE = 8.0
"""Fewest degrees of freedom, all values together, that a verdict is made from."""
MIN_SCALE_RATIO = 1.25
"""A scale within this factor of 1 is no fault, however significant."""

# -- segments

MIN_SEGMENT_UPDATES = 2
"""Fewest updates of a segment."""
MAX_SEGMENTS = 4
"""Most segments of a track."""
MIN_CORRELATION_TIME = 1.3
"""Correlation time of the NIS above which a change point costs more."""
MIN_UPDATES_FOR_CORRELATION_TIME = 20
"""Fewest updates for which a correlation time of the NIS is estimated."""
MAX_END_UPDATES = 8
"""Most updates at either end of a track that the end tests take together."""
EFFECTIVE_END_TESTS = 4.0
"""The tests of 1 to 8 values share values: at a level of 0.005 they count as no more than 3.3
independent ones for 10 to 300 updates of 1 to 4 degrees of freedom (simulated); 4 is assumed."""

# -- outliers

MIN_UPDATES_FOR_OUTLIERS = 10
"""Fewest updates of a track whose outliers are removed."""
MAX_OUTLIER_SHARE = 0.12
"""Above this share of the updates, large values are a fault and no outliers."""
MIN_ISOLATED_SHARE = 0.7
"""Share of the large values that must stand alone."""
MAX_RUN = 2
"""Most consecutive large values that one bad measurement makes."""
RUN_GAP = 3
"""Large values that are no further apart than this belong to one run."""
MIN_P_WITHOUT_SPIKE = 0.05
"""A segment is too large by one value alone if the rest has at least this p-value."""

# -- verdict from segments

MAX_STARTUP_SHARE = 0.5
"""Largest share of the track that a bad start may last."""
MIN_LATE_SHARE = 0.4
"""Share of the track after which a late fault begins, if the track before it is too large too."""
MIN_PESSIMISTIC_SHARE = 0.5
"""Share of the updates that must be too small for ``pessimistic``."""
MIN_OPTIMISTIC_SHARE = 0.6
"""Share of the updates that must be too large for ``optimistic`` if some segment is not."""
MAX_SCALE_BEFORE_LATE = 0.6
"""After a bad start, a late fault must follow a segment with less than this share of its scale."""
MAX_FADED_SHARE = 0.2
"""A last segment with less than this share of the largest scale is the tail of a past fault."""
MIN_LATE_GROWTH = 5.0
"""Factor by which the last segment must exceed earlier ones that are too large already."""
MAX_P_TOO_LARGE = 0.001
"""A beginning with a smaller p-value is itself too large, so that no later fault is "late"."""
MIN_P_RECOVERED = 0.05
"""P-value of the last updates from which a late fault counts as over."""

# -- bias, whiteness and cause

MIN_UPDATES_FOR_BIAS = 8
"""Fewest values of a component, or errors of a state, that are tested for a bias."""
MIN_EXPLAINED_SHARE = 0.5
"""Share of the excess that a bias must explain to become the verdict."""
MAX_P_WIDE_RESIDUALS = 0.05
"""P-value below which residuals count as wider than their covariances say."""
MIN_PAIRS_FOR_CORRELATION = 8
"""Fewest pairs of values of which a correlation is estimated."""
MAX_ROBUST_DEVIATIONS = 3.0
"""Robust standard deviations at which an innovation is clipped before correlations are taken."""
MAX_P_SIZE = 0.05
"""P-value (two-sided) below which the size of correlated innovations decides their verdict."""
CAUSE_ALPHA_SHARE = 0.6
"""Share of alpha at which a correlation names a cause: a wrong cause is worse than none."""
MIN_LASTING_SCALE = 1.1
"""Scale that the second half of the innovations must exceed for a cause to be named."""
MAX_LASTING_SCALE = 30.0
"""Scale above which the filter has lost its target and no noise level explains it."""

# -- NIS and NEES together

MIN_NEES_SCALE_OF_BIAS = 2.0
"""A NEES above this scale should show a bias of the innovations that is real."""
MAX_P_BEFORE_FAULT = 1e-4
"""P-value below which the NEES before a fault was too large already."""
BEFORE_FAULT_SHARE = 2 / 3
"""Share of the updates before a fault that stand for what was before it."""

# -- states and angles

MAX_EXACT_STATES = 10
"""Up to this many states the Shapley values are exact."""
NUM_SAMPLED_ORDERS = 2000
"""Orders of the states that are sampled above that number."""
STD_GROWTH_LIMIT = 2.0
"""Growth of a claimed standard deviation that marks the onset of a loss of information."""
VARIANCE_REDUCTION = 0.5
"""Share of the variance that an update must remove for the state to count as observed."""
NIS_MATCH_TOLERANCE = 1e-6
"""Relative difference at which a logged NIS is that of a (wrapped or unwrapped) innovation."""
MIN_STEPS_FOR_COURSE = 5
"""Fewest movements from which the unit of a course is judged."""

# -- CUSUM

CUSUM_ALPHA = 0.01
"""Default false-alarm probability of the cumulative sums."""
CUSUM_SCALE_HIGH = 2.5
"""Default scale that the sum for "NIS too large" looks for."""
CUSUM_SCALE_LOW = 0.4
"""Default scale that the sum for "NIS too small" looks for."""

# -- simulated quantiles

SEED = 20260224
"""Seed of everything that is drawn: a diagnosis is deterministic."""
NUM_DRAWS = 4000
"""Simulated sequences for the penalty of a change point."""
MAX_PATTERN_LENGTH = 1024
"""Penalties of longer patterns are simulated on blocks of updates; the quantile has converged."""
UNIFORM_PENALTY_RATIO = 1.2
"""The penalty of a mixed pattern is within this factor of that of a uniform one."""
MAX_DOF_RATIO = 10.0
"""Largest ratio of degrees of freedom within a pattern for which that holds."""
