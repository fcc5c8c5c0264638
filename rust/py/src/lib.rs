//! `trackmetrics._native`: the Rust kernels, as Python sees them.
//!
//! Every function here borrows its arguments, lets go of the interpreter where the work is worth
//! it, calls one function of `trackmetrics-core`, and converts what comes back. There is no
//! arithmetic in this crate.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `lists` | reading NumPy arrays and lists of them; the only `unsafe` code |
//! | `convert`, `tensor` | the argument types that kernels take |
//! | `error` | core errors as Python exceptions |
//! | `interrupt` | Ctrl-C in long kernels |
//! | the rest | one thin file for each module of core |

#![deny(unsafe_code)]
// PyO3's macros write the documentation of what they generate.
#![allow(missing_docs)]

mod accuracy;
mod assignment;
mod consistency;
mod convert;
mod diagnostics;
mod error;
mod identities;
mod interrupt;
mod lists;
mod monte_carlo;
mod noise_likelihood;
mod point_sets;
mod results;
mod settings;
mod tensor;
mod tracking;
mod trajectories;
mod vessel;

#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use crate::{
        accuracy::{estimation_error_bounds, monte_carlo_rmse, position_rmse, rmse, velocity_rmse},
        assignment::{
            auction, bottleneck_assignment, linear_sum_assignment, linear_sum_assignment_batch,
        },
        consistency::{
            credibility_interval, mean_statistic, nees, nees_sequence, nis, nis_sequence,
        },
        diagnostics::{
            best_split_gains, first_alarms, nees_inflation, sampled_shapley_shares,
            scale_partitions, shapley_shares,
        },
        identities::{box_pairs, clear_mot, hota, identities, matrix_pairs, position_pairs},
        monte_carlo::{consistency_sums, histograms, run_sums},
        noise_likelihood::noise_likelihood,
        point_sets::{
            gospa, gospa_from_distances, gospa_over_time, mahalanobis_distances, ospa,
            ospa_assignment, ospa_from_distances, ospa_over_time, point_distances,
        },
        settings::{set_simd, set_threads, simd, threads},
        tracking::{identity_switches, mot_metrics, track_fragmentation, track_purity},
        trajectories::ospa2,
        vessel::{vessel_advance, vessel_filter, vessel_gate, vessel_predict},
    };
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
