"""Our functions under the names of other libraries."""

from trackmetrics.compat.pytcl import patch_pytcl, unpatch_pytcl

__all__ = ["patch_pytcl", "unpatch_pytcl"]
