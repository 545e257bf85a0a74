//! The page of a report and its sections, from top to bottom.

mod errors;
mod frames;
mod pictures;
mod sizes;

use crate::Error;
use crate::evaluate::{Frames, OWN_WEIGHTS};
use crate::examples::Split;
use crate::page::html::{self, grouped, section, text};
use crate::progress::Progress;
use crate::report::comparison::{Comparison, MeasuredModel};
use crate::report::pictures::{PictureOptions, Pictures};
use crate::report::sizes::Sizes;
use crate::space::written;

/// The page of a comparison.
pub struct Page<'a> {
    /// The models and their errors.
    pub comparison: &'a Comparison<'a>,
    /// Options of the pictures.
    pub options: PictureOptions,
    /// Whether the model's predictor is trained again with more and fewer proxies.
    pub sizes: bool,
}

impl Page<'_> {
    /// Writes the page: one HTML file that needs neither network nor script.
    ///
    /// The same comparison gives the same bytes for any number of threads, except the seconds of trainings, if there
    /// are any.
    ///
    /// # Errors
    /// The runtime refuses a frame, or a picture cannot be encoded.
    pub fn html(&self, progress: &dyn Progress) -> Result<String, Error> {
        let Self { comparison, options, .. } = *self;
        let sizes = self.sizes.then(|| Sizes::train(comparison, progress));
        progress.part(1, 1);
        progress.step("pictures", 1);
        let pictures = Pictures::new(comparison, &options);
        let near_rigid =
            sizes.as_ref().and_then(|sizes| sizes.as_ref().ok()?.near_rigid.as_deref());
        let worst = comparison.source.label(comparison.model.measured.frames[pictures.worst].frame);
        let sections = [
            header(comparison),
            section("Accuracy", &errors::accuracy(comparison)),
            section(&format!("The worst pose: {worst}"), &pictures::worst_pose(&pictures)?),
            section("Error by vertex, over all frames", &pictures::all_frames(&pictures)?),
            section("Error by frame", &frames::errors(comparison)),
            section("Error by joint", &errors::by_joint(comparison)),
            section("How errors are distributed", &errors::histogram(comparison)),
            section("Confidence", &frames::confidence(comparison)),
            sizes.as_ref().map_or(String::new(), |sizes| {
                section("More or fewer helpers", &sizes::errors(comparison, sizes))
            }),
            section("Transforms that move each vertex", &pictures::palette(&pictures, near_rigid)?),
        ];
        let title = format!("{} on {}", comparison.model.file.name, comparison.source.name);
        Ok(html::page(&title, &(sections.concat() + &footer(comparison))))
    }
}

fn header(comparison: &Comparison<'_>) -> String {
    let Comparison { source, model, baselines, .. } = comparison;
    let examples = source.examples;
    let (errors, lbs) = (model.measured.errors(), baselines.lbs.measured.errors());
    let compared = |other: &MeasuredModel<'_>| format!(", compared with {}", text(other.file.name));
    let compared = comparison.other.as_ref().map(compared).unwrap_or_default();
    let own_weights = baselines.own_weights.as_ref().map(|own| own.measured.errors());
    let normals = format!(
        " Its normals are turned by <b>{:.2}°</b>, RMS over the area (linear blend skinning: {:.2}°{}).",
        errors.normal_rms_degrees,
        lbs.normal_rms_degrees,
        own_weights.map_or(String::new(), |own| {
            format!(", {OWN_WEIGHTS}: {:.2}°", own.normal_rms_degrees)
        })
    );
    let mm = errors.millimetres.map(|of| format!(" (<b>{} mm</b>)", written(of.rms_mm)));
    let share = errors.share_of(&lbs).map(|share| {
        let lbs = comparison.length(lbs.rms_percent);
        format!(": {:.1} % of the error of linear blend skinning, {lbs}", 100.0 * share)
    });
    let own_weights = own_weights.and_then(|own| {
        let (share, own) = (errors.share_of(&own)?, comparison.length(own.rms_percent));
        Some(format!("; {:.1} % of the error of {OWN_WEIGHTS}, {own}", 100.0 * share))
    });
    let verdict = format!(
        "The model is off by <b>{:.4} %</b> of the diagonal{}, RMS{}{}.",
        errors.rms_percent,
        mm.unwrap_or_default(),
        share.unwrap_or_default(),
        own_weights.unwrap_or_default()
    );
    format!(
        "<h1>{} on {}{compared}</h1>\n\
         <p class=\"under\">{} vertices, {} triangles, {}, diagonal {:.4}{}; {}{}</p>\n\
         <p class=\"verdict\">{verdict}{normals}</p>\n",
        text(model.file.name),
        text(source.name),
        grouped(examples.vertex_len()),
        grouped(examples.triangles.len()),
        examples.pose_size(),
        examples.diagonal(),
        model.measured.diagonal_mm.map_or(String::new(), |mm| format!(" ({} mm)", written(mm))),
        measured_on(comparison),
        read_by_other(comparison)
    )
}

/// Says which frames are measured, and whether the training read them.
fn measured_on(comparison: &Comparison<'_>) -> String {
    let examples = comparison.source.examples;
    let frames = comparison.model.measured.frames.len();
    let count = grouped(frames);
    let better = "a fit is always better on frames that it has read than on new frames";
    match (comparison.frames, comparison.model.read) {
        (Frames::Of(Split::Extreme), None | Some(0)) => format!(
            "measured on {count} extreme frames, beyond the range of motion of the training"
        ),
        (Frames::New, _) => format!("measured on {count} frames that the fit has not read"),
        (Frames::Of(Split::HeldOut), None) => format!("measured on {count} held-out frames"),
        (Frames::Of(Split::HeldOut), Some(0)) => {
            format!("measured on {count} held-out frames, which the fit has not read")
        }
        (Frames::Of(Split::Train), None) => {
            format!("measured on the {count} training frames: {better}")
        }
        (Frames::Of(Split::Train), Some(read)) if read == frames => {
            format!("measured on the {count} frames that the fit has read: {better}")
        }
        (Frames::Of(split), Some(read)) => format!(
            "measured on {count} {} frames, of which the fit has read {}: {better}",
            split.name(),
            grouped(read)
        ),
        (Frames::All, read) => {
            let uses = || (0..examples.frame_len()).map(|frame| comparison.use_of(frame));
            let of =
                |split| format!("{} {}", uses().filter(|own| *own == split).count(), split.name());
            let [train, held_out, extreme] = [Split::Train, Split::HeldOut, Split::Extreme].map(of);
            let read = read.map_or(String::new(), |read| {
                format!("; the fit has read {} of them", grouped(read))
            });
            format!("measured on all {count} frames: {train}, {held_out}, {extreme}{read}")
        }
    }
}

/// Says how many measured frames the second model's training read, if the number differs from the first model's.
fn read_by_other(comparison: &Comparison<'_>) -> String {
    let Some(other) = &comparison.other else { return String::new() };
    let read = other.read.unwrap_or(0);
    if read == comparison.model.read.unwrap_or(0) {
        return String::new();
    }
    let frames = comparison.model.measured.frames.len();
    let of = if read == frames { "all".to_owned() } else { grouped(read) };
    format!("; {} has read {of} of them in training", text(other.file.name))
}

fn footer(comparison: &Comparison<'_>) -> String {
    let crc = |bytes: &[u8]| crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(bytes);
    let named = |model: &MeasuredModel<'_>| {
        format!("{} (CRC-32 {:08x})", text(model.file.name), crc(model.file.bytes))
    };
    let files: Vec<_> = comparison.models().map(named).collect();
    format!(
        "<footer>sinew {}; measured by the f32 runtime on the bytes of {}.</footer>\n",
        env!("CARGO_PKG_VERSION"),
        files.join(" and ")
    )
}
