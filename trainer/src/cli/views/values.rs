//! Parameters as the command line gives them.

use anyhow::bail;
use sinew_trainer::views::set::Values;

/// Parses `name=number`.
pub(super) fn assignment(text: &str) -> Result<(String, f64), String> {
    let parts = text.split_once('=').ok_or("expected NAME=NUMBER")?;
    match parts.1.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok((parts.0.to_owned(), number)),
        _ => Err(format!("expected a number for {}, found \"{}\"", parts.0, parts.1)),
    }
}

/// Takes parameters by name, none of them twice.
pub(super) fn values(all: &[(String, f64)]) -> anyhow::Result<Values> {
    let mut out = Values::new();
    for (name, value) in all {
        if out.insert(name.clone(), *value).is_some() {
            bail!("parameter \"{name}\" is given twice");
        }
    }
    Ok(out)
}
