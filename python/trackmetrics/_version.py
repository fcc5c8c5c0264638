"""The version.

A literal, since reading the package's metadata costs a third of ``import numpy``. The extension
carries the version of ``Cargo.toml``; the two are compared when it is loaded.
"""

__version__ = "0.1.0"
