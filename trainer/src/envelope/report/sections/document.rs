//! The page: its sections from top to bottom.

use super::error::ReportError;
use super::series::errors;
use super::{frames, histogram, joints, pictures, sizes};
use crate::envelope::evaluate::Frames;
use crate::envelope::report::shots::{Shots, Wish};
use crate::envelope::report::sizes::Sizes;
use crate::envelope::report::subject::{Series, Subject, use_of};
use crate::examples::Split;
use crate::page::html::{self, grouped, paragraph, percent, section, table, text};
use crate::progress::Progress;

/// A report on what was measured.
pub struct Page<'a> {
    /// What was measured.
    pub subject: &'a Subject<'a>,
    /// How the pictures are taken.
    pub wish: Wish,
    /// Whether the model's predictor is trained again with more and with fewer proxies.
    pub sizes: bool,
}

impl Page<'_> {
    /// Writes the page: one HTML file that needs neither network nor script.
    ///
    /// The same subject gives the same bytes for any number of threads, but for the seconds that the
    /// trainings took, which it tells where there are any.
    ///
    /// # Errors
    /// [`ReportError::Evaluate`] and [`ReportError::Picture`].
    pub fn html(&self, progress: &dyn Progress) -> Result<String, ReportError> {
        let Self { subject, wish, .. } = *self;
        let sizes = self.sizes.then(|| Sizes::train(subject, progress));
        progress.part(1, 1);
        progress.step("pictures", 1);
        let shots = Shots::new(subject, &wish);
        let near_rigid =
            sizes.as_ref().and_then(|sizes| sizes.as_ref().ok()?.near_rigid.as_deref());
        let worst = subject.source.label(subject.model.measured.frames[shots.worst].frame);
        let sections = [
            header(subject),
            section("Accuracy", &accuracy(subject)),
            section(&format!("The worst pose: {worst}"), &pictures::worst_pose(&shots, subject)?),
            section("Where it errs, over all frames", &pictures::all_frames(&shots, subject)?),
            section("Error by frame", &frames::errors(subject)),
            section("Error by joint", &joints::errors(subject)),
            section("How errors are distributed", &histogram::errors(subject)),
            section("Confidence", &frames::confidence(subject)),
            section("More or fewer proxies", &sizes::errors(subject, sizes.as_ref())),
            section("What moves each vertex", &pictures::palette(&shots, subject, near_rigid)?),
        ];
        let title = format!("{} on {}", subject.model.file.name, subject.source.name);
        Ok(html::page(&title, &(sections.concat() + &footer(subject))))
    }
}

fn header(subject: &Subject<'_>) -> String {
    let Subject { source, model, baseline, .. } = subject;
    let examples = source.examples;
    let (errors, lbs) = (model.measured.errors(), baseline.errors());
    let compared = subject
        .other
        .as_ref()
        .map_or(String::new(), |other| format!(", compared with {}", text(other.file.name)));
    let share = 100.0 * errors.rms / lbs.rms;
    let verdict = if share.is_finite() {
        format!(
            "The model is off by <b>{} %</b> of the diagonal, RMS: {share:.1} % of what linear blend \
             skinning leaves ({} %).",
            percent(errors.rms_percent),
            percent(lbs.rms_percent)
        )
    } else {
        format!(
            "The model is off by <b>{} %</b> of the diagonal, RMS.",
            percent(errors.rms_percent)
        )
    };
    format!(
        "<h1>{} on {}{compared}</h1>\n\
         <p class=\"under\">{} vertices, {} triangles, {} joints, diagonal {:.4}; {}</p>\n\
         <p class=\"verdict\">{verdict}</p>\n",
        text(model.file.name),
        text(source.name),
        grouped(examples.vertex_len()),
        grouped(examples.triangles.len()),
        grouped(examples.joint_len()),
        examples.diagonal(),
        measured_on(subject)
    )
}

/// Says in words which frames are measured, and what to think of that.
fn measured_on(subject: &Subject<'_>) -> String {
    let examples = subject.source.examples;
    let count = grouped(subject.baseline.frames.len());
    match subject.frames {
        Frames::Of(Split::HeldOut) => {
            format!("measured on {count} held-out frames, which the fit has not read")
        }
        Frames::Of(Split::Extreme) => {
            format!(
                "measured on {count} extreme frames, beyond the range of motion of the training"
            )
        }
        Frames::Of(Split::Train) if examples.frames_of(Split::HeldOut).is_empty() => format!(
            "measured on the {count} training frames, because the examples hold none out: a fit is \
             always better on what it has read than on what it will meet"
        ),
        Frames::Of(Split::Train) => format!(
            "measured on the {count} training frames: a fit is always better on what it has read \
             than on what it will meet"
        ),
        Frames::All => {
            let of = |split| format!("{} {}", examples.frames_of(split).len(), use_of(split));
            let [train, held_out, extreme] = [Split::Train, Split::HeldOut, Split::Extreme].map(of);
            format!("measured on all {count} frames: {train}, {held_out}, {extreme}")
        }
    }
}

fn accuracy(subject: &Subject<'_>) -> String {
    let head =
        ["", "RMS", "99 % are below", "largest", "normals, RMS", "confidence", "palette", "file"];
    let row = |series: &Series<'_>| {
        let mut row = vec![text(series.name)];
        row.extend(errors(&series.measured.errors()));
        row.extend(match series.model {
            None => ["", "", ""].map(str::to_owned),
            Some(model) => {
                let (confidence, envelope) =
                    (series.measured.confidence(), &model.character.envelope);
                let proxies = match envelope.proxy_len() {
                    0 => "joints alone".to_owned(),
                    count => format!("{}, {count} proxies", envelope.predictor().name()),
                };
                let bytes = format!("{} B", grouped(model.file.bytes.len()));
                [format!("{:.3}", confidence.mean), proxies, bytes]
            }
        });
        row
    };
    let rows: Vec<_> = subject.series().iter().map(row).collect();
    table(&head.map(str::to_owned), &rows)
        + &paragraph(
            "Errors are distances of vertices from where the examples have them, in % of the diagonal \
             of the rest pose's box; normals are compared by angle. LBS is linear blend skinning with \
             4 influences a vertex, fitted to the same training frames.",
        )
}

fn footer(subject: &Subject<'_>) -> String {
    let crc = |bytes: &[u8]| crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(bytes);
    let files = subject
        .models()
        .map(|model| format!("{} (CRC-32 {:08x})", text(model.file.name), crc(model.file.bytes)));
    let files: Vec<_> = files.collect();
    format!(
        "<footer>sinew {}; measured by the f32 runtime on the bytes of {}.</footer>\n",
        env!("CARGO_PKG_VERSION"),
        files.join(" and ")
    )
}
