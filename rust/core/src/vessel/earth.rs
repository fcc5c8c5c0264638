//! Metres per degree on the WGS-84 ellipsoid, and the wrapping of angles.
//!
//! The series in the latitude phi,
//!
//! north(phi) = 111132.954 - 559.822 cos 2 phi + 1.175 cos 4 phi,
//! east(phi) = 111412.84 cos phi - 93.5 cos 3 phi + 0.118 cos 5 phi,
//!
//! is the usual one for the length of a degree (National Geospatial-Intelligence Agency, *The
//! American Practical Navigator*, table "Length of a Degree of Latitude and Longitude"); it stays
//! within 5 cm of the ellipsoid's radii of curvature.

/// Radians in a degree.
pub const RADIAN: f64 = std::f64::consts::PI / 180.0;

/// Metres per second in a knot: the international nautical mile of 1852 m in 3600 s.
pub const KNOT: f64 = 1852.0 / 3600.0;

/// Least length of a degree of longitude. Within a kilometre of a pole a local plane in degrees has
/// no meaning; the floor keeps what is computed there finite.
const LEAST_EAST: f64 = 100.0;

/// Lengths of a degree at one latitude, in metres, and how fast they change with latitude.
#[derive(Debug, Clone, Copy)]
pub struct Degree {
    /// Metres in a degree of latitude.
    pub north: f64,
    /// Metres in a degree of longitude.
    pub east: f64,
    /// Metres more in a degree of latitude, one degree further north.
    pub north_slope: f64,
    /// Metres more in a degree of longitude, one degree further north.
    pub east_slope: f64,
}

/// The lengths of a degree at a latitude in degrees.
#[inline]
pub fn degree(latitude: f64) -> Degree {
    let phi = latitude * RADIAN;
    // cos and sin of the multiples by recurrence: one call of sin_cos instead of nine.
    let (s1, c1) = phi.sin_cos();
    let (c2, s2) = (c1 * c1 - s1 * s1, 2.0 * s1 * c1);
    let (c3, s3) = (c2 * c1 - s2 * s1, s2 * c1 + c2 * s1);
    let (c4, s4) = (c2 * c2 - s2 * s2, 2.0 * s2 * c2);
    let (c5, s5) = (c4 * c1 - s4 * s1, s4 * c1 + c4 * s1);
    let east = 111412.84 * c1 - 93.5 * c3 + 0.118 * c5;
    let at_pole = east < LEAST_EAST;
    Degree {
        north: 111132.954 - 559.822 * c2 + 1.175 * c4,
        east: if at_pole { LEAST_EAST } else { east },
        north_slope: (1119.644 * s2 - 4.7 * s4) * RADIAN,
        east_slope: if at_pole { 0.0 } else { (-111412.84 * s1 + 280.5 * s3 - 0.59 * s5) * RADIAN },
    }
}

/// The same angle in (-180, 180].
#[inline]
pub fn wrap_difference(angle: f64) -> f64 {
    if angle > -180.0 && angle <= 180.0 {
        return angle;
    }
    180.0 - (180.0 - angle).rem_euclid(360.0)
}

/// The same course in [0, 360).
#[inline]
pub fn wrap_course(angle: f64) -> f64 {
    let wrapped = angle.rem_euclid(360.0);
    // A tiny negative angle rounds up to the whole turn.
    if wrapped == 360.0 { 0.0 } else { wrapped }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Radii of curvature of WGS-84 (a = 6378137 m, 1/f = 298.257223563), in metres per degree.
    fn ellipsoid(latitude: f64) -> (f64, f64) {
        let (a, f) = (6378137.0, 1.0 / 298.257223563);
        let e2: f64 = f * (2.0 - f);
        let w = 1.0 - e2 * (latitude * RADIAN).sin().powi(2);
        let meridian = a * (1.0 - e2) / w.powf(1.5);
        let parallel = a / w.sqrt() * (latitude * RADIAN).cos();
        (meridian * RADIAN, parallel * RADIAN)
    }

    #[test]
    fn the_series_is_the_ellipsoid_to_centimetres() {
        for latitude in -89..=89 {
            let found = degree(f64::from(latitude));
            let (north, east) = ellipsoid(f64::from(latitude));
            assert!((found.north - north).abs() < 0.05, "{latitude}: {} {north}", found.north);
            assert!((found.east - east).abs() < 0.05, "{latitude}: {} {east}", found.east);
        }
    }

    #[test]
    fn slopes_are_derivatives() {
        for latitude in [-85.0, -30.0, 0.0, 0.5, 45.0, 74.5] {
            let (below, above, here) =
                (degree(latitude - 1e-4), degree(latitude + 1e-4), degree(latitude));
            assert!(((above.north - below.north) / 2e-4 - here.north_slope).abs() < 1e-4);
            assert!(((above.east - below.east) / 2e-4 - here.east_slope).abs() < 1e-4);
        }
    }

    #[test]
    fn nothing_is_infinite_at_the_poles() {
        for latitude in [90.0, -90.0, 89.9999, 91.0] {
            assert_eq!(degree(latitude).east, 100.0);
        }
    }

    #[test]
    fn angles_wrap_to_their_ranges() {
        for (angle, difference, course) in [
            (0.0, 0.0, 0.0),
            (180.0, 180.0, 180.0),
            (-180.0, 180.0, 180.0),
            (190.0, -170.0, 190.0),
            (-190.0, 170.0, 170.0),
            (540.0, 180.0, 180.0),
            (-1e-17, -1e-17, 0.0),
        ] {
            assert_eq!(wrap_difference(angle), difference);
            assert_eq!(wrap_course(angle), course);
        }
    }
}
