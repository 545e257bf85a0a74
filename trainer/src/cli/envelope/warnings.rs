//! Warnings of a training: findings of the check, and a model without a gain over LBS.

use sinew_trainer::check::finding::{Finding, Kind, Severity};
use sinew_trainer::evaluate::NOTHING;
use sinew_trainer::settings::{TIED, UNSEEN};
use sinew_trainer::space::beside;

/// Share of LBS's error from which a model is hardly better.
const HARDLY: f64 = 0.9;

/// Returns whether a training prints a finding of the check: a warning, or triangles that the fit leaves out. Examples
/// of one pose, or too far from the origin, are refused in the same words.
pub(super) fn is_told(finding: &&Finding) -> bool {
    match finding.kind {
        Kind::OnePose | Kind::TooFar => false,
        Kind::NoArea => true,
        _ => finding.severity == Severity::Warning,
    }
}

/// Warns where a model gains nothing over LBS: forecast for more of these clips and error of LBS in % of the diagonal.
///
/// - `known`: whether a warning said before that LBS leaves nothing.
pub(super) fn no_gain(
    forecast: f64,
    lbs: f64,
    diagonal_mm: Option<f64>,
    known: bool,
) -> Option<String> {
    match lbs <= NOTHING {
        true if !known => Some(nothing(lbs)),
        _ if forecast > NOTHING => hardly(forecast, lbs, diagonal_mm),
        _ => None,
    }
}

/// Says that LBS leaves nothing to learn, in % of the diagonal.
fn nothing(lbs: f64) -> String {
    format!(
        "the meshes are what linear blend skinning makes of them, which leaves {lbs:.6} % of the diagonal: there is \
         nothing to learn, and skinning alone does as well; give the meshes that muscles, a simulation or \
         correctives make"
    )
}

/// Says that a model is hardly better than LBS, no better, or worse, where it is; errors in % of the diagonal.
fn hardly(forecast: f64, lbs: f64, diagonal_mm: Option<f64>) -> Option<String> {
    if forecast <= HARDLY * lbs {
        return None;
    }
    let [own, of_lbs] =
        [forecast, lbs].map(|percent| format!("{percent:.4} %{}", beside(percent, diagonal_mm)));
    let is_tied = forecast <= TIED * lbs && lbs <= TIED * forecast;
    let (how, figures) = match own == of_lbs {
        true => ("no better", format!("both are off by {own} of the diagonal")),
        false => {
            let how = if is_tied {
                "no better"
            } else if forecast > lbs {
                "worse"
            } else {
                "hardly better"
            };
            (how, format!("it is off by {own} of the diagonal, linear blend skinning by {of_lbs}"))
        }
    };
    let then = match lbs <= 100.0 * UNSEEN && is_tied {
        true => "skinning alone does as well, and nobody sees so small an error",
        false => "`sinew check` tells what the examples lack",
    };
    Some(format!(
        "the model is {how} than linear blend skinning on poses that it has not seen: {figures}; {then}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_that_print_alike_are_not_called_worse() {
        let said = |validated, lbs| hardly(validated, lbs, None).unwrap();
        let tie = said(0.009_512, 0.009_498);
        assert!(
            tie.contains("is no better than linear") && tie.contains("both are off by 0.0095 % of"),
            "{tie}"
        );
        assert!(tie.contains("skinning alone does as well"), "{tie}");
        let tie = said(0.5004, 0.5);
        assert!(
            tie.contains("no better") && tie.contains("0.5004 %") && tie.contains("by 0.5000 %"),
            "{tie}"
        );
        assert!(
            said(0.6, 0.5).contains("is worse than")
                && said(0.46, 0.5).contains("hardly better than")
        );
        assert_eq!(hardly(0.4, 0.5, None), None);
        let known = hardly(0.6, 0.5, Some(2000.0)).unwrap();
        assert!(
            known.contains("0.6000 % (12.000 mm)") && known.contains("0.5000 % (10.000 mm)"),
            "{known}"
        );
        let said = |lbs, known| no_gain(0.5, lbs, None, known).unwrap();
        assert!(said(0.0, false).contains("nothing to learn") && said(0.0, true).contains("worse"));
        assert_eq!(no_gain(0.0, 0.0, None, true), None);
    }
}
