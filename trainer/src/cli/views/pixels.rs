//! `sinew views train --pixels`: the negative control.

use super::input::SetArguments;
use crate::cli::{Output, counted};
use anyhow::Context;
use serde_json::json;
use sinew_trainer::views::control::control;
use sinew_trainer::views::fit::FitOptions;

/// Prints the PSNR of networks over pixels beside that of control points and warping.
///
/// # Errors
/// Views that cannot be read or taken.
pub(super) fn run(set: &SetArguments, options: FitOptions, output: Output) -> anyhow::Result<()> {
    let about = || set.file().display().to_string();
    let found = control(&set.read()?, options).with_context(about)?;
    let [one, many] = match found.is_left_out {
        true => ["key view, left out", "key views, each left out"],
        false => ["test view", "test views"],
    };
    let figure = |psnr: Option<f64>| psnr.map_or_else(String::new, |psnr| format!("{psnr:.2} dB"));
    let mut text =
        "negative control: networks over pixels (S1, appendix 2); no file is written\n".to_owned();
    let mut line = |name: &str, whole: &str, opaque: &str| {
        text += &format!("{name:<40}{whole:>14}{opaque:>14}\n");
    };
    line(&counted(found.views, one, many), "whole pictures", "where opaque");
    for row in &found.rows {
        line(&row.name, &figure(row.psnr), &figure(row.psnr_opaque));
    }
    text += "a network over Fourier transforms gives the same pictures: both are linear\n";
    output.print(&json!({ "negative_control": found }), &text)
}
