//! A painted character with each clip held out in turn: compares the model with the artist's
//! weights. Forecasts of the error (METHOD §1.2, §1.9).

use crate::shared::shared;
use sinew_runtime::Model;
use sinew_trainer::envelope::demo::{DemoOptions, demo};
use sinew_trainer::envelope::evaluate::{Evaluation, Frames, evaluate};
use sinew_trainer::envelope::rotational::ProxyCount;
use sinew_trainer::envelope::{Options, train};
use sinew_trainer::examples::{Split, npz};
use sinew_trainer::progress::Silent;

/// Trains without a clip. Returns the errors on this clip and the forecast for another clip, in %
/// of the diagonal.
fn held_out(clip: &str) -> Option<(Evaluation, f64)> {
    let mut loaded = npz::load(&shared("../cases/rigs/biped.npz")?).unwrap();
    loaded.examples.hold_out_clips(&loaded.clips, &[clip.to_owned()]).unwrap();
    let model = train(&loaded.examples, &Options::default(), &Silent).unwrap().model;
    let file = Model::from_bytes(&model).unwrap();
    let certificate = file.envelope().unwrap().certificate();
    let forecast = f64::from(certificate.other_clip_rms.unwrap() / certificate.diagonal);
    let found = evaluate(&model, None, &loaded.examples, Frames::Of(Split::HeldOut)).unwrap();
    Some((found, 100.0 * forecast))
}

#[test]
fn an_unseen_clip_is_no_worse_than_by_own_or_fitted_weights_and_is_forecast() {
    // The smaller of two RMS errors, by an independent measurement: of the artist's weights, and of
    // fitted weights before the pull to the artist's.
    for (clip, least) in [("Walk 歩き", 0.171), ("Wave & look", 0.163), ("Squat + squash", 0.226)]
    {
        let Some((found, forecast)) = held_out(clip) else { return };
        let (model, lbs) = (found.errors.rms_percent, found.lbs.rms_percent);
        assert!(model <= 1.02 * least && lbs <= 1.02 * least, "{clip}: {model} {lbs} {least}");
        let ratio = forecast / model;
        assert!((0.7..4.0).contains(&ratio), "{clip}: the forecast is {ratio} times the error");
    }
}

#[test]
fn no_forecast_is_below_the_error_on_the_frames_that_were_read() {
    // Forecasts use 250 vertices, which leave less data for 60 helpers than the 2,500 vertices do.
    let examples = demo(&DemoOptions { vertices: 2500, poses: 120, held_out: 0, seed: 1 });
    let options = Options { proxies: Some(ProxyCount::Fixed(60)), ..Options::default() };
    let report = train(&examples, &options, &Silent).unwrap().report;
    assert!(report.same_clips_rms >= report.training_rms, "{report:?}");
}
