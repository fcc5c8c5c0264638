"""Motion of the five-state estimator of vessels: reference implementation.

State x = (latitude deg, longitude deg, speed kt, course deg, turn rate deg/s). The formulas and
their sources stand at the head of the core's files; here they are once more, one state at a time.
"""

import numpy as np

from trackmetrics._numpy.arguments import Floats

RADIAN = np.pi / 180.0


KNOT = 1852.0 / 3600.0


LEAST_EAST = 100.0


LONGEST_PIECE = 600.0


Motion = tuple[float, float, float, float]


def degree(latitude: float) -> tuple[float, float, float, float]:
    """Metres in a degree of latitude and of longitude, and their slopes per degree north."""
    phi = latitude * RADIAN
    north = 111132.954 - 559.822 * np.cos(2 * phi) + 1.175 * np.cos(4 * phi)
    north_slope = (1119.644 * np.sin(2 * phi) - 4.7 * np.sin(4 * phi)) * RADIAN
    east = 111412.84 * np.cos(phi) - 93.5 * np.cos(3 * phi) + 0.118 * np.cos(5 * phi)
    slope = -111412.84 * np.sin(phi) + 280.5 * np.sin(3 * phi) - 0.59 * np.sin(5 * phi)
    if east < LEAST_EAST:
        return north, LEAST_EAST, north_slope, 0.0
    return north, east, north_slope, slope * RADIAN


def wrap_difference(angle: float) -> float:
    """The same angle in (-180, 180]."""
    return angle if -180.0 < angle <= 180.0 else 180.0 - (180.0 - angle) % 360.0


def wrap_course(angle: float) -> float:
    """The same course in [0, 360)."""
    wrapped = angle % 360.0
    return 0.0 if wrapped == 360.0 else wrapped


def turned_time(time: float, decay: float) -> float:
    """The time for which a constant turn rate would turn as far."""
    return time if np.isinf(decay) else -decay * np.expm1(-time / decay)


def mean_time(time: float, decay: float) -> float:
    """The time after which the heading is the mean heading."""
    r = time / decay
    if np.isinf(decay):
        return 0.5 * time
    if r < 1e-3:
        return time * (0.5 - r / 6 + r * r / 24)
    return decay * (1 - turned_time(time, decay) / time)


def sinc(h: float) -> tuple[float, float]:
    """sin h / h and its derivative."""
    if abs(h) < 1e-2:
        h2 = h * h
        value = 1 - h2 / 6 * (1 - h2 / 20 * (1 - h2 / 42))
        return value, -h / 3 * (1 - h2 / 10 * (1 - h2 / 28))
    return np.sin(h) / h, (h * np.cos(h) - np.sin(h)) / h**2


def step(x: Floats, time: float, decay: float) -> tuple[Floats, Floats]:
    """The state after one piece of time, and its Jacobian."""
    latitude, longitude, speed, course, rate = x
    turned, mean = turned_time(time, decay), mean_time(time, decay)
    left = 1.0 if np.isinf(decay) else np.exp(-time / decay)
    a, (s, slope) = (course + rate * mean) * RADIAN, sinc(0.5 * rate * RADIAN * turned)
    direction, across = np.array([np.cos(a), np.sin(a)]), np.array([-np.sin(a), np.cos(a)])
    chord = KNOT * time * s * speed
    m_north, _, m_north_slope, _ = degree(latitude)
    north = chord * direction[0] / m_north
    _, m_east, _, m_east_slope = degree(latitude + 0.5 * north)
    east = chord * direction[1] / m_east
    end = np.array(
        [
            latitude + north,
            wrap_difference(longitude + east),
            speed,
            wrap_course(course + rate * turned),
            rate * left,
        ]
    )
    by_speed = KNOT * time * s * direction
    by_course = chord * across * RADIAN
    by_rate = (
        KNOT * time * speed * slope * direction * 0.5 * turned + chord * across * mean
    ) * RADIAN
    f = np.eye(5)
    f[0, 0] = 1 - north * m_north_slope / m_north
    by_middle = -east * m_east_slope / m_east
    f[1, 0] = by_middle * 0.5 * (1 + f[0, 0])
    f[0, 2:] = np.array([by_speed[0], by_course[0], by_rate[0]]) / m_north
    f[1, 2:] = np.array([by_speed[1], by_course[1], by_rate[1]]) / m_east
    f[1, 2:] += by_middle * 0.5 * f[0, 2:]
    f[3, 4], f[4, 4] = turned, left
    return end, f


def turning(t: float, decay: float) -> Floats:
    """Integrals of the products of (g2, g1, g0) over a time: a 3 x 3 matrix."""
    if np.isinf(decay):
        return np.array(
            [
                [t**5 / 20, t**4 / 8, t**3 / 6],
                [t**4 / 8, t**3 / 3, t**2 / 2],
                [t**3 / 6, t**2 / 2, t],
            ]
        )
    nodes, weights = np.polynomial.legendre.leggauss(5)
    integral = np.zeros((3, 3))
    for node, weight in zip((nodes + 1) / 2 * t, weights / 2 * t, strict=True):
        g = np.array(
            [node * mean_time(node, decay), turned_time(node, decay), np.exp(-node / decay)]
        )
        integral += weight * np.outer(g, g)
    return integral


def noise(x: Floats, t: float, motion: Motion) -> Floats:
    """The covariance that the noise adds over one piece of time."""
    along, turn, walk, decay = motion
    v, a = x[2] * KNOT, (x[3] + x[4] * mean_time(t, decay)) * RADIAN
    scale = np.array([v * RADIAN, 1.0, 1.0])
    cross = turn * np.outer(scale, scale) * turning(t, decay)
    cross[:2, :2] += (
        walk * np.outer(scale, scale)[:2, :2] * np.array([[t**3 / 3, t**2 / 2], [t**2 / 2, t]])
    )
    block = np.zeros((5, 5))  # along (m), across (m), speed (m/s), course (deg), rate (deg/s)
    block[np.ix_([0, 2], [0, 2])] = along * np.array([[t**3 / 3, t**2 / 2], [t**2 / 2, t]])
    block[np.ix_([1, 3, 4], [1, 3, 4])] = cross
    m_north, m_east, _, _ = degree(x[0])
    turned = np.diag([0.0, 0.0, 1 / KNOT, 1.0, 1.0])
    turned[0, :2] = np.cos(a) / m_north, -np.sin(a) / m_north
    turned[1, :2] = np.sin(a) / m_east, np.cos(a) / m_east
    result: Floats = turned @ block @ turned.T
    return result


def pieces(time: float, decay: float) -> int:
    """Into how many pieces a time is cut."""
    return int(np.clip(np.ceil(time / min(LONGEST_PIECE, decay / 4)), 1, 10_000))


def carry(x: Floats, p: Floats, time: float, motion: Motion) -> tuple[Floats, Floats, Floats]:
    """State, covariance and Jacobian after a time."""
    count = pieces(time, motion[3])
    jacobian = np.eye(5)
    for _ in range(count):
        q = noise(x, time / count, motion)
        x, f = step(x, time / count, motion[3])
        p, jacobian = f @ p @ f.T + q, f @ jacobian
    return x, (p + p.T) * 0.5, jacobian
