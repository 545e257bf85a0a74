//! The figures of `../shared/reference`.

use serde_json::Value;
use std::path::Path;

/// Reads `hbf_reference.json`; none where there is no shared data, which continuous integration must
/// have.
pub(crate) fn reference() -> Option<Value> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/reference");
    let file = folder.join("hbf_reference.json");
    if file.exists() {
        return Some(serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap());
    }
    assert!(std::env::var_os("CI").is_none(), "hbf_reference.json must be in ../shared/reference");
    eprintln!("hbf_reference.json is not in ../shared/reference: not tested");
    None
}

/// Returns a list of figures.
pub(crate) fn figures(list: &Value) -> Vec<f64> {
    list.as_array().unwrap().iter().map(|figure| figure.as_f64().unwrap()).collect()
}

/// Returns the middle of an even number of figures.
pub(crate) fn median(mut figures: Vec<f64>) -> f64 {
    figures.sort_by(f64::total_cmp);
    let half = figures.len() / 2;
    0.5 * (figures[half - 1] + figures[half])
}
