"""Simulation of the demo: a small multi-target scene and a tracker that follows it.

Targets move with nearly constant velocity; a sensor misses some and sees others that are not there;
a global-nearest-neighbour tracker with a Kalman filter per track follows them.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import count

import numpy as np
from numpy.typing import NDArray

import trackmetrics as tm

Floats = NDArray[np.float64]

# The scene, in metres and seconds.
STEP = 1.0
BOX = 1000.0
SPEED = 10.0
PROCESS = 0.2  # power spectral density of the acceleration, m^2/s^3
SENSOR = 5.0  # standard deviation of each measured coordinate
DETECTED = 0.9  # share of targets that the sensor sees in a scan
CLUTTER = 1.0  # false detections in a scan, on average
GATE = 13.8  # 99.9 % point of NIS with two degrees of freedom
LOST_AFTER = 3  # scans without a detection until a track is dropped

_F = np.kron(np.eye(2), [[1.0, STEP], [0.0, 1.0]])
_Q = np.kron(np.eye(2), PROCESS * np.array([[STEP**3 / 3, STEP**2 / 2], [STEP**2 / 2, STEP]]))
_H = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])
_R = SENSOR**2 * np.eye(2)
_P0 = np.diag([SENSOR**2, SPEED**2, SENSOR**2, SPEED**2]).astype(np.float64)


@dataclass
class Scene:
    """What happened in one run, and what the tracker said of it."""

    truth: list[Floats] = field(default_factory=list)
    """Target positions of each scan, ``(targets, 2)``."""
    reports: list[Floats] = field(default_factory=list)
    """Positions of the confirmed tracks of each scan, ``(tracks, 2)``."""
    true_labels: list[int] = field(default_factory=list)
    """For each update by a target's detection: which target it was."""
    track_labels: list[int] = field(default_factory=list)
    """For each of those updates: which track it was."""
    true_states: list[Floats] = field(default_factory=list)
    estimated_states: list[Floats] = field(default_factory=list)
    covariances: list[Floats] = field(default_factory=list)
    innovations: list[Floats] = field(default_factory=list)
    innovation_covariances: list[Floats] = field(default_factory=list)


@dataclass
class Track:
    """One target as the tracker sees it: state [x, vx, y, vy] and its covariance."""

    label: int
    state: Floats
    covariance: Floats
    updates: int = 1
    missed: int = 0

    def predict(self) -> None:
        """One scan ahead."""
        self.state = _F @ self.state
        self.covariance = _F @ self.covariance @ _F.T + _Q

    def innovation(self, detection: Floats) -> tuple[Floats, Floats]:
        """Measured minus predicted position, and its covariance."""
        return detection - _H @ self.state, _H @ self.covariance @ _H.T + _R

    def update(self, detection: Floats) -> None:
        """Fuse one detection; Joseph's form keeps the covariance symmetric."""
        residual, s = self.innovation(detection)
        gain = np.linalg.solve(s, _H @ self.covariance).T
        keep = np.eye(4) - gain @ _H
        self.state = self.state + gain @ residual
        self.covariance = keep @ self.covariance @ keep.T + gain @ _R @ gain.T
        self.updates, self.missed = self.updates + 1, 0


def simulate(rng: np.random.Generator, targets: int, scans: int) -> Scene:
    """One run of the scene."""
    scene, tracks = Scene(), list[Track]()
    states = np.zeros((targets, 4))
    states[:, [0, 2]] = rng.uniform(0, BOX, (targets, 2))
    states[:, [1, 3]] = rng.normal(0, SPEED, (targets, 2))
    jitter = np.linalg.cholesky(_Q)
    labels = count()
    for _ in range(scans):
        states = states @ _F.T + rng.normal(size=(targets, 4)) @ jitter.T
        detections, origins = _detect(rng, states)
        tracks = _scan(scene, tracks, states, detections, origins, labels)
        scene.truth.append(states @ _H.T)
        confirmed = [_H @ track.state for track in tracks if track.updates > 2]
        scene.reports.append(np.array(confirmed).reshape(-1, 2))
    return scene


def _detect(rng: np.random.Generator, states: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """What the sensor sees, and of which target; -1 for a false detection."""
    seen = np.flatnonzero(rng.random(len(states)) < DETECTED)
    noise = rng.normal(0, SENSOR, (len(seen), 2))
    false = rng.uniform(0, BOX, (rng.poisson(CLUTTER), 2))
    origins = np.concatenate([seen, np.full(len(false), -1)])
    return np.concatenate([states[seen] @ _H.T + noise, false]), origins


def _scan(
    scene: Scene,
    tracks: list[Track],
    states: Floats,
    detections: Floats,
    origins: NDArray[np.int64],
    labels: Iterator[int],
) -> list[Track]:
    """Predict, associate, update, start and drop."""
    for track in tracks:
        track.predict()
        track.missed += 1
    free = set(range(len(detections)))
    for i, j in _associate(tracks, detections):
        free.discard(j)
        _record(scene, tracks[i], detections[j], int(origins[j]), states)
    kept = [track for track in tracks if track.missed < LOST_AFTER]
    return kept + [Track(next(labels), _H.T @ detections[j], _P0.copy()) for j in sorted(free)]


def _associate(tracks: list[Track], detections: Floats) -> list[tuple[int, int]]:
    """Pairs of tracks and detections at the least total distance, inside the gate."""
    if not tracks or not len(detections):
        return []
    predicted = np.array([_H @ track.state for track in tracks])
    s = np.array([_H @ track.covariance @ _H.T + _R for track in tracks])
    residuals = detections[None] - predicted[:, None]
    spread = np.ascontiguousarray(np.broadcast_to(s[:, None], (*residuals.shape, 2)))
    distances = tm.nis(residuals, spread)
    rows, columns = tm.linear_sum_assignment(np.minimum(distances, GATE))
    return [(i, j) for i, j in zip(rows, columns, strict=True) if distances[i, j] < GATE]


def _record(scene: Scene, track: Track, detection: Floats, origin: int, states: Floats) -> None:
    """Update a track, and keep what the consistency tests need where a target caused it."""
    residual, s = track.innovation(detection)
    track.update(detection)
    if origin < 0 or track.updates < 3:
        return
    scene.true_labels.append(origin)
    scene.track_labels.append(track.label)
    scene.true_states.append(states[origin].copy())
    scene.estimated_states.append(track.state)
    scene.covariances.append(track.covariance)
    scene.innovations.append(residual)
    scene.innovation_covariances.append(s)
