"""What can be wrong with an argument: the Python side of the one table of messages.

The Rust core has the same texts in ``rust/core/src/error.rs``; a test holds the two against each
other, so that a message does not depend on the backend.
"""

from collections.abc import Sequence


class NotPlain(TypeError):  # noqa: N818 - a signal between two layers, not a user's error
    """An argument is not in the form that a kernel reads by itself.

    Internal: the public function converts the argument and calls the kernel again.
    """


def format_index(index: Sequence[int]) -> str:
    """An index as Python writes it: ``[3][1]``."""
    return "".join(f"[{i}]" for i in index)


def not_finite(argument: str, index: Sequence[int], value: float) -> ValueError:
    """A value that must be finite is not."""
    return ValueError(f"{argument}{format_index(index)} is not finite: {float(value)!r}")


def dimension(argument: str, index: Sequence[int], found: int, expected: int) -> ValueError:
    """A point has another number of coordinates than the points before it."""
    return ValueError(
        f"{argument}{format_index(index)} has {found} coordinates, expected {expected}"
    )


def parameter(argument: str, requirement: str, value: float) -> ValueError:
    """A number outside the range that the definition allows."""
    return ValueError(f"{argument} must be {requirement}, got {float(value)!r}")


def length(argument: str, found: int, other: str, expected: int, unit: str) -> ValueError:
    """Two sequences that must be equally long are not."""
    return ValueError(f"{argument} has {found} {unit}, {other} has {expected}")


def shape(argument: str, found: Sequence[int], expected: str) -> ValueError:
    """An array has a shape that the function does not take."""
    return ValueError(f"{argument} has shape {tuple(found)}, expected {expected}")


def empty(argument: str) -> ValueError:
    """An argument without elements, where a mean is asked for."""
    return ValueError(f"{argument} is empty")


def element(argument: str, index: Sequence[int], requirement: str, value: float) -> ValueError:
    """A number of an array outside the range that the definition allows."""
    return ValueError(
        f"{argument}{format_index(index)} must be {requirement}, got {float(value)!r}"
    )


def axis_out_of_range(found: int, axes: int) -> ValueError:
    """An axis that the array does not have, or that was named before."""
    return ValueError(f"axis must be among the {axes} axes of the array, each once, got {found}")


def index_out_of_range(argument: str, place: int, found: int, length: int) -> ValueError:
    """An index that is outside what it points into."""
    return ValueError(f"{argument}[{place}] is {found}, the state has {length} components")


def offsets(argument: str, points: int) -> ValueError:
    """Offsets of packed sets that do not rise from 0 to the number of points."""
    return ValueError(f"{argument}: starts must rise from 0 to {points}, the number of points")


def not_symmetric(argument: str, index: Sequence[int], row: int, column: int) -> ValueError:
    """A covariance whose two triangles disagree."""
    return ValueError(
        f"{argument}{format_index(index)} is not symmetric: "
        f"elements [{row}, {column}] and [{column}, {row}] differ"
    )


def not_positive_definite(argument: str, index: Sequence[int], minor: int) -> ValueError:
    """A covariance that is not positive definite."""
    from numpy.linalg import LinAlgError

    return LinAlgError(
        f"{argument}{format_index(index)} is not positive definite (leading minor {minor})"
    )


def not_a_matrix(axes: int) -> ValueError:
    """A cost matrix with another number of axes than two."""
    return ValueError(f"expected a matrix (2-D array), got a {axes} array")


def too_many_pairs(pairs: int, size: int) -> ValueError:
    """More pairs of points than fit into memory."""
    return ValueError(
        f"{pairs} pairs of points would take {size} bytes: take a smaller c or fewer points"
    )


def steps_not_increasing(argument: str, index: int) -> ValueError:
    """The steps of a trajectory do not rise."""
    return ValueError(f"{argument}[{index}]: steps must rise")


def invalid_costs() -> ValueError:
    """A cost matrix with an element that no assignment can use."""
    return ValueError("matrix contains invalid numeric entries")


def in_matrix(index: int, error: Exception) -> Exception:
    """One of many cost matrices cannot be used."""
    return type(error)(f"costs[{index}]: {error}")


def infeasible() -> ValueError:
    """A cost matrix in which every complete assignment has an infinite cost."""
    return ValueError("cost matrix is infeasible")
