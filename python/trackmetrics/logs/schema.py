"""The columns that a log can have, by what each row of them holds."""

SCALAR_COLUMNS = ("nis", "nis_dof", "nees", "nees_dof")
"""One number."""
DOF_COLUMNS = ("nis_dof", "nees_dof")
"""Degrees of freedom."""
STATE_VECTOR_COLUMNS = ("x_pred", "x", "truth", "error", "std")
"""One number for each state."""
STATE_MATRIX_COLUMNS = ("P_pred", "P", "A")
"""One ``n x n`` matrix."""
MEASUREMENT_VECTOR_COLUMNS = ("z", "innovation")
"""One number for each component of the measurement."""
MEASUREMENT_MATRIX_COLUMNS = ("S", "R")
"""One ``m x m`` matrix."""
OBSERVATION_COLUMNS = ("H",)
"""One ``m x n`` matrix."""
STRING_COLUMNS = ("status", "measurement_type")
"""One text."""
COVARIANCE_COLUMNS = ("P_pred", "P", "S", "R")
"""Symmetric matrices, written as their upper triangle."""
NUMERIC_COLUMNS = (
    *SCALAR_COLUMNS,
    *STATE_VECTOR_COLUMNS,
    *STATE_MATRIX_COLUMNS,
    *MEASUREMENT_VECTOR_COLUMNS,
    *MEASUREMENT_MATRIX_COLUMNS,
    *OBSERVATION_COLUMNS,
)
"""Every column of numbers."""
COLUMN_NAMES = ("track", "time", "observed", *STRING_COLUMNS, *NUMERIC_COLUMNS)
"""Every column."""
STATUSES = ("tentative", "active", "rejected")
"""What a status can be."""
COVARIANCE_FORMS = ("diagonal", "upper", "full")
"""How the elements of a covariance can be given."""
