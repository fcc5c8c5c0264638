"""Colours: one per track and one per verdict, for light and dark themes.

A primitive names a *role* ("ink", "high", "track-3", "track-3/0.2" with an opacity); a theme maps
roles to colours, so that one figure works in both themes. The colours of tracks can be told apart
under simulated protanopia, deuteranopia and tritanopia (``tests/report/test_theme.py`` measures
it); after eight tracks the colours repeat with another dash.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from trackmetrics.diagnostics import Diagnosis

TRACK_COLOURS = 8
DASHES = ("solid", "dash", "dot", "dashdot")


@dataclass(frozen=True)
class Theme:
    """A colour for each role."""

    name: str
    """``"light"`` or ``"dark"``."""
    colours: Mapping[str, str]
    """Hexadecimal colours by role."""

    def colour(self, role: str) -> str:
        """The colour of a role, as ``#rrggbb``."""
        return self.colours[role.partition("/")[0]]

    def rgba(self, role: str) -> tuple[float, float, float, float]:
        """The colour of a role and its opacity, each from 0 to 1."""
        digits = self.colour(role).lstrip("#")
        red, green, blue = (int(digits[i : i + 2], 16) / 255 for i in (0, 2, 4))
        return red, green, blue, opacity(role)

    def css(self, role: str) -> str:
        """The colour of a role as CSS writes it."""
        red, green, blue, alpha = self.rgba(role)
        return f"rgba({red * 255:.0f},{green * 255:.0f},{blue * 255:.0f},{alpha:g})"


def opacity(role: str) -> float:
    """The opacity that a role asks for: ``"band/0.3"`` is 0.3, ``"band"`` is 1."""
    return float(role.partition("/")[2] or 1)


def _colours(tracks: Sequence[str], **roles: str) -> Mapping[str, str]:
    return {**roles, **{f"track-{i}": colour for i, colour in enumerate(tracks)}}


LIGHT = Theme(
    "light",
    _colours(
        (
            "#1c40bb",
            "#eb6f04",
            "#41a392",
            "#731f67",
            "#b676fc",
            "#715a00",
            "#3e75a4",
            "#680803",
        ),
        surface="#ffffff",
        page="#f5f6f8",
        ink="#1c2128",
        muted="#5b6573",
        grid="#e4e7ec",
        edge="#c3c9d2",
        band="#7d8da3",
        high="#a8201a",
        warning="#a86400",
        low="#1257c4",
        consistent="#1f8a5e",
        unknown="#6b7280",
    ),
)
DARK = Theme(
    "dark",
    _colours(
        (
            "#7c8dff",
            "#ef9a18",
            "#8bfed7",
            "#c38290",
            "#a45aab",
            "#e9f12f",
            "#5eceff",
            "#c9432f",
        ),
        surface="#171b21",
        page="#0f1216",
        ink="#e8ebf0",
        muted="#9aa5b4",
        grid="#272d36",
        edge="#434c59",
        band="#8fa3bd",
        high="#ff7568",
        warning="#f0a321",
        low="#5aaaff",
        consistent="#7fe0b4",
        unknown="#9aa2af",
    ),
)
THEMES = (LIGHT, DARK)

_VERDICT_COLOUR = {
    "angle_wrap_bug": "high",
    "late_divergence": "high",
    "startup_then_consistent": "warning",
    "startup_then_pessimistic": "warning",
    "biased": "high",
    "optimistic": "high",
    "transient": "warning",
    "pessimistic": "low",
    "partly_pessimistic": "low",
    "outliers": "warning",
    "non_white": "warning",
    "consistent": "consistent",
    "insufficient": "unknown",
}
_SYMBOLS = {"high": "▲", "warning": "◆", "low": "▼", "consistent": "●", "unknown": "○"}


def theme(dark: bool) -> Theme:
    """The dark theme or the light one."""
    return DARK if dark else LIGHT


def verdict_role(verdict: str) -> str:
    """The role whose colour a verdict has."""
    return _VERDICT_COLOUR[verdict]


def verdict_symbol(verdict: str) -> str:
    """A symbol for readers who do not see colours: ▲ optimistic, ▼ pessimistic, ● consistent."""
    return _SYMBOLS[_VERDICT_COLOUR[verdict]]


def verdict_label(verdict: str) -> str:
    """A verdict as it is printed: without underscores."""
    return verdict.replace("_", " ")


def segment_role(verdict: str) -> str:
    """The role whose colour a segment with this verdict has."""
    return {"optimistic": "high", "pessimistic": "low"}.get(verdict, verdict)


@dataclass(frozen=True)
class TrackStyle:
    """How a track looks in every figure."""

    colour: str
    """Its role."""
    dash: str
    """Its dash, one of :data:`DASHES`."""


def track_styles(diagnosis: Diagnosis) -> dict[str, TrackStyle]:
    """The look of each track: the most severe ones first, so that these differ most."""
    styles = {}
    for i, track in enumerate(diagnosis.by_severity()):
        turn = i // TRACK_COLOURS
        styles[track.track] = TrackStyle(f"track-{i % TRACK_COLOURS}", DASHES[turn % len(DASHES)])
    return styles
