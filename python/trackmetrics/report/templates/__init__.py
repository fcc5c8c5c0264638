"""The Jinja2 templates of the pages."""

from typing import Any


def environment() -> Any:
    """The Jinja2 environment: HTML is escaped, and an undefined name is an error."""
    import jinja2

    return jinja2.Environment(
        loader=jinja2.PackageLoader("trackmetrics.report"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
