"""Colours that stay apart: measured in OKLab, for four kinds of colour vision.

Simulation: Machado, Oliveira and Fernandes (2009), doi:10.1109/TVCG.2009.113, severity 1.
"""

import itertools

import numpy as np
import pytest

from trackmetrics.diagnostics import VERDICTS, Diagnosis
from trackmetrics.report import theme

_CONES = np.array(
    [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
)
_LAB = np.array(
    [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
)
_VISION = {
    "normal": np.eye(3),
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}


def linear(colour):
    """A hexadecimal colour in linear light."""
    c = np.array([int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def seen(colour, vision):
    """A colour in OKLab as somebody with this vision sees it."""
    light = np.clip(np.array(_VISION[vision]) @ linear(colour), 0, 1)
    return _LAB @ np.cbrt(_CONES @ light)


def contrast(a, b):
    """The ratio of contrast of WCAG 2."""
    low, high = sorted(linear(c) @ [0.2126, 0.7152, 0.0722] for c in (a, b))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("name", ["light", "dark"])
@pytest.mark.parametrize("vision", _VISION)
def test_tracks_stay_apart(name, vision):
    colours = theme.theme(name == "dark").colours
    tracks = [colours[f"track-{i}"] for i in range(theme.TRACK_COLOURS)]
    least = 0.06 if vision == "tritanopia" else 0.11
    for a, b in itertools.combinations(tracks, 2):
        assert np.linalg.norm(seen(a, vision) - seen(b, vision)) > least, (a, b)


@pytest.mark.parametrize("chosen", theme.THEMES, ids=lambda t: t.name)
def test_everything_is_legible(chosen):
    for role, colour in chosen.colours.items():
        if role in ("ink", "muted", "high", "warning", "low", "consistent", "unknown"):
            assert contrast(colour, chosen.colours["surface"]) > 4.2, role
        if role.startswith("track-"):
            assert contrast(colour, chosen.colours["surface"]) > 2.9, role


def test_every_verdict_has_a_colour_a_shape_and_words():
    for verdict in VERDICTS:
        assert theme.verdict_role(verdict) in theme.LIGHT.colours
        assert theme.verdict_symbol(verdict)
        assert "_" not in theme.verdict_label(verdict)


def test_a_role_with_an_opacity():
    assert theme.LIGHT.css("high/0.25") == "rgba(168,32,26,0.25)"
    assert theme.DARK.rgba("ink")[3] == 1


def test_every_track_has_one_look(fleet):
    styles = theme.track_styles(fleet[1])
    assert len(styles) == 100
    first = list(styles.values())[:32]
    assert len({(s.colour, s.dash) for s in first}) == 32
    assert theme.track_styles(Diagnosis(())) == {}
