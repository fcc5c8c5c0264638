"""What the functions give back.

The NamedTuples are those of ``pytcl.performance_evaluation``, field for field.
"""

from typing import NamedTuple


class OSPAResult(NamedTuple):
    """OSPA distance and its two parts, all in the unit of the points; 0 is best, ``c`` is worst.

    ``ospa ** p == localization ** p + cardinality ** p``.
    """

    ospa: float
    """The distance."""
    localization: float
    """The part owed to the distances of matched points."""
    cardinality: float
    """The part owed to the difference in cardinality."""
