"""The version, read from the package's metadata: it is written once, in ``Cargo.toml``."""

from importlib.metadata import version

__version__ = version("trackmetrics")
