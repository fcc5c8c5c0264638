//! States of more numbers than the lanes factor: one run, step by step.

use super::batch::Batch;
use super::elementwise::{FORM_COLUMNS, decibels, wrap};
use super::histogram::{BINS, bin};
use super::run_block::{Group, Output};
use crate::error::Result;

/// Fills the row and the sums of the only run of the group, and counts.
pub(super) fn reduce(group: &Group<'_>, output: Output<'_>) -> Result<()> {
    let Output { row, of_runs, counts, histogram } = output;
    let steps = group.batch.steps;
    let forms = group.batch.forms(group.first, 1)?;
    row.fill(0.0);
    for (step, &form) in forms.iter().enumerate().filter(|(_, form)| !form.is_nan()) {
        let b = decibels(form);
        let of_form = [form, form * form, b, (b - group.levels.decibels).abs()];
        let columns = of_form.into_iter().chain(of_states(group.batch, group.place(0, step)));
        for (column, x) in columns.enumerate() {
            row[column * steps + step] = x;
        }
        counts[step] += 1;
        for (under, &threshold) in
            counts[steps..].chunks_exact_mut(steps).zip(group.levels.thresholds)
        {
            under[step] += i64::from(form <= threshold);
        }
        histogram[step * BINS + bin(form)] += 1;
    }
    let squares = row[(FORM_COLUMNS + group.batch.dimension()) * steps..].chunks_exact(steps);
    of_runs[0] = forms.iter().filter(|form| !form.is_nan()).count() as f64;
    of_runs[1] = row[..steps].iter().sum();
    of_runs[2..].iter_mut().zip(squares).for_each(|(sum, column)| *sum = column.iter().sum());
    Ok(())
}

/// e, e^2 and e / sqrt(P_jj) of each state at a place in the batch.
fn of_states(batch: &Batch<'_>, at: usize) -> Vec<f64> {
    let d = batch.dimension();
    let mut errors = batch.truth[at * d..(at + 1) * d].to_vec();
    if let Some(estimates) = batch.estimates {
        errors.iter_mut().zip(&estimates[at * d..]).for_each(|(error, x)| *error -= x);
    }
    wrap(&mut errors, batch.periods);
    let variances = batch.covariances[at * d * d..(at + 1) * d * d].iter().step_by(d + 1);
    let squares = errors.iter().map(|e| e * e);
    let normalised = errors.iter().zip(variances).map(|(e, variance)| e / variance.sqrt());
    errors.iter().copied().chain(squares).chain(normalised).collect()
}
