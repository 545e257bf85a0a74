//! `sinew inspect`: parts, figures and bytes of a model file.

use super::arguments::{ModelArgs, describe_space, space_as_json};
use super::{Output, Report, Run, printable};
use crate::space::{millimetres, written};
use serde_json::json;
use sinew_runtime::filter::{Filter, FilterFit};
use sinew_runtime::format::{Element, PartKind, PartRow, SectionKind};
use sinew_runtime::kernel::{KernelMap, OutputKind};
use sinew_runtime::record::{Record, RecordCounts};
use sinew_runtime::views::{Layer, Views};
use sinew_runtime::{Envelope, Model, Prior, Section, Skin};
use std::collections::BTreeSet;

/// Shows the parts, figures and bytes of a model file
///
/// Envelopes predict palettes. Skins are meshes that follow palettes. Kernels are functions of scattered data. Priors
/// describe which shapes of a face move together. Views are pictures and the pictures between them. Filters make
/// signals finer. Records hold the training of an envelope. The axes and the unit of the numbers are shown too.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  sinew inspect model.sinew --json")]
pub(super) struct Inspect {
    #[command(flatten)]
    model: ModelArgs,
}

impl Run for Inspect {
    fn run(&self, _: Output) -> anyhow::Result<Report> {
        let model = self.model.load()?;
        let (space, len) = (model.space(), model.as_bytes().len());
        let unit_mm = millimetres(&space);
        let records = model.all::<Record>().map(|record| of_record(&record));
        let lists: [(&str, Vec<Report>); 7] = [
            (
                "envelopes",
                model.all::<Envelope>().map(|part| of_envelope(&part, unit_mm)).collect(),
            ),
            ("skins", model.all::<Skin>().map(|part| of_skin(&model, &part)).collect()),
            ("records", records.collect()),
            ("kernels", model.all::<KernelMap>().map(|part| of_kernel(&part)).collect()),
            ("priors", model.all::<Prior>().map(|part| of_prior(&part)).collect()),
            ("views", model.all::<Views>().map(|part| of_views(&part)).collect()),
            ("filters", model.all::<Filter>().map(|part| of_filter(&part)).collect()),
        ];
        let kind = |row: PartRow| PartKind::from_number(row.kind).map(PartKind::name);
        let kinds: Vec<_> = model.parts().map(|row| json!({ "kind": kind(row) })).collect();
        let parts = lists.iter().flat_map(|(_, parts)| parts);
        let titles: Vec<&str> = parts.map(|part| part.title.as_str()).collect();
        let section = |section: Section<'_>| {
            let part = section.row.part;
            let name =
                titles.iter().find_map(|title| title.strip_suffix(&format!(", part {part}")));
            Report::default()
                .figure("kind", "section", kind_name(&section), "")
                .shown("part", "part", part, name.unwrap_or("unknown"))
                .figure("element", "element", element_name(&section), "")
                .figure("bytes", "bytes", section.bytes.len(), "")
        };
        let sections: Vec<_> = model.sections().map(section).collect();
        let in_sections: usize = model.sections().map(|section| section.bytes.len()).sum();
        let report = Report::default()
            .shown("bytes", "", len, format!("{}: {len} bytes", self.model.file.display()))
            .shown("space", "", space_as_json(&space), format!("space: {}", describe_space(&space)))
            .json("parts", kinds);
        let report = lists.into_iter().fold(report, |report, (key, parts)| report.list(key, parts));
        let (report, other) = (report.list("sections", sections), len - in_sections);
        Ok(report.figure("other_bytes", "head, tables and padding", other, "bytes"))
    }
}

fn kind_name(section: &Section<'_>) -> String {
    let known = SectionKind::from_number(section.row.kind).map(SectionKind::name);
    known.map_or_else(|| format!("unknown {}", section.row.kind), str::to_owned)
}

fn element_name(section: &Section<'_>) -> String {
    let number = section.row.element;
    let known = Element::ALL.into_iter().find(|element| element.number() == number);
    known.map_or_else(|| format!("unknown {number}"), |element| element.name().to_owned())
}

fn of_envelope(envelope: &Envelope<'_>, unit_mm: Option<f64>) -> Report {
    let joint_name = |joint| envelope.joint_name(joint).unwrap_or_default();
    let joint = |joint| {
        let range = envelope.pose_range(joint);
        let (parent, degrees) = (envelope.parent(joint), range.unwrap_or_default().to_degrees());
        Report::default()
            .figure("name", "joint", envelope.joint_name(joint), "")
            .shown("parent", "parent", parent, parent.map_or("-", joint_name))
            .shown("range", "trained to", range, format!("{degrees:.1} °"))
            .json("gap", envelope.pose_gap(joint))
    };
    let groups = envelope.groups().map(|group| {
        Report::default()
            .shown("joint", "group", group.joint, joint_name(group.joint))
            .figure("proxies", "helpers", group.proxies.len(), "")
            .figure("inputs", "inputs", group.input_len(), "")
            .figure("centres", "centres", group.centre_len(), "")
            .figure("rank", "rank", group.rank(), "")
            .figure("kernel", "kernel", group.kernel.name(), "")
    });
    let certificate = envelope.certificate();
    let diagonal = certificate.diagonal;
    let mut errors =
        Report::default().figure("diagonal", "diagonal of the rest mesh", diagonal, "units");
    errors = errors.text("certificate: RMS error, % of the diagonal");
    for (key, label, rms) in [
        ("training_rms", "training frames", Some(certificate.training_rms)),
        ("same_clips_rms", "more of these clips", Some(certificate.same_clips_rms)),
        ("other_clip_rms", "another clip", certificate.other_clip_rms),
        ("base_training_rms", "without its correction", Some(certificate.base_training_rms)),
        ("lbs_training_rms", "LBS, training frames", Some(certificate.lbs_training_rms)),
        ("correction_error", "rounding, bound", Some(certificate.correction_error)),
        ("trs_error", "helpers as bones (TRS), largest change", Some(certificate.trs_error)),
    ] {
        let mm = unit_mm.zip(rms).map(|(unit, rms)| unit * f64::from(rms));
        let length = mm.map_or(String::new(), |mm| format!("  {} mm", written(mm)));
        errors = match rms {
            Some(rms) => {
                let percent = 100.0 * rms / diagonal;
                errors.shown(key, label, rms, format!("{percent:.4} %{length}"))
            }
            None => errors.json(key, rms),
        };
        if let Some(mm) = mm {
            errors = errors.json(&format!("{key}_mm"), mm);
        }
    }
    if let Some(unit) = unit_mm {
        errors = errors.json("diagonal_mm", unit * f64::from(diagonal));
    }
    Report::of_part("envelope", envelope.part(), envelope.name())
        .figure("predictor", "predictor", envelope.predictor().name(), "")
        .figure("proxies", "helpers", envelope.proxy_len(), "")
        .figure("helper_kind", "kind of helpers", envelope.helper_kind().name(), "")
        .figure("palette", "transforms of the palette", envelope.palette_len(), "")
        .figure("scratch_bytes", "scratch", 4 * envelope.scratch_len(), "bytes")
        .json("skeleton_hash", envelope.skeleton_hash())
        .part("certificate", errors)
        .list("joints", (0..envelope.joint_len()).map(joint))
        .list("groups", groups)
}

fn of_skin(model: &Model<Vec<u8>>, skin: &Skin<'_>) -> Report {
    let envelope = model.envelope_of(skin);
    let follows = envelope.map(|envelope| format!("envelope \"{}\"", printable(envelope.name())));
    let coefficients = if skin.has_coefficients() { "tangent coefficients" } else { "cofactors" };
    let normals = skin.normal_errors().map(|errors| {
        let [model, cofactors, lbs] =
            errors.figures().map(|angle| format!("{:.2} °", angle.to_degrees()));
        Report::default()
            .shown("model", "normals, RMS, training frames", errors.model, model)
            .shown("cofactors", "normals of a stock shader", errors.cofactors, cofactors)
            .shown("lbs", "normals of LBS, the same frames", errors.lbs, lbs)
    });
    let element = skin.shape_element().name();
    let shapes = Report::default().figure("count", "shapes", skin.shape_len(), "").figure(
        "element",
        "numbers of the shapes",
        element,
        "",
    );
    let shapes = match skin.shape_errors() {
        Some(errors) => shapes
            .figure("largest_error", "error of the shapes, largest", errors.largest, "units")
            .figure("rms_error", "error of the shapes, RMS", errors.rms, "units"),
        None => shapes,
    };
    let ranges = skin.ranges().map(|(name, range)| {
        Report::default()
            .figure("name", "mesh", name, "")
            .figure("start", "first vertex", range.start, "")
            .figure("end", "end", range.end, "")
    });
    Report::of_part("skin", skin.part(), skin.name())
        .shown("envelope_part", "follows", skin.envelope_part(), follows.as_deref().unwrap_or("-"))
        .figure("vertices", "vertices", skin.vertex_len(), "")
        .figure("influences", "influences a vertex", skin.influence_len(), "")
        .figure("tangents", "tangents", skin.has_tangents(), "")
        .shown("tangent_coefficients", "normals by", skin.has_coefficients(), coefficients)
        .json("mesh_hash", skin.mesh_hash())
        .part_or_null("normal_errors", normals)
        .part_or_null("shapes", (skin.shape_len() > 0).then_some(shapes))
        .list("ranges", ranges)
}

fn of_record(record: &Record<'_>) -> Report {
    let RecordCounts { frame_len, influence_len, .. } = record.counts();
    Report::of_part("record", record.part(), record.name())
        .json("envelope", record.name())
        .figure("training_frames", "training frames", frame_len, "")
        .figure("lbs_influences", "influences of fitted LBS", influence_len, "")
}

fn of_kernel(map: &KernelMap<'_>) -> Report {
    let (counts, rule, fit) = (map.counts(), map.rule(), map.fit());
    let inputs = map.inputs().enumerate().map(|(input, row)| {
        Report::default()
            .figure("name", "input", map.input_name(input), "")
            .figure("kind", "kind", row.kind.name(), "")
            .figure("axis", "axis", (row.axis != [0.0; 3]).then_some(row.axis), "")
    });
    let outputs = map.outputs().enumerate().map(|(output, row)| {
        let (low, high) = row.range;
        let is_scalar = row.kind == OutputKind::Scalar;
        let is_free = !is_scalar || (low, high) == (f32::MIN, f32::MAX);
        let range = if is_free { "-".to_owned() } else { format!("{low} to {high}") };
        Report::default()
            .figure("name", "output", map.output_name(output), "")
            .figure("kind", "kind", row.kind.name(), "")
            .shown("range", "range", is_scalar.then_some([low, high]), range)
            .figure("normalised", "a share of a sum", row.is_marked, "")
    });
    let fit = Report::default()
        .figure("rms_residual", "error at the samples, RMS", fit.rms_residual, "")
        .figure("left_out_rms", "error at samples left out, RMS", fit.left_out_rms, "")
        .figure("rounding_error", "error of f32, bound", fit.rounding_error, "")
        .figure("reciprocal_condition", "reciprocal condition", fit.reciprocal_condition, "");
    Report::of_part("kernel", map.part(), map.name())
        .figure("kernel", "kernel", rule.kernel.name(), "")
        .figure("outside", "outside the samples", rule.query.name(), "")
        .figure("normalise", "normalisation", rule.normalise.name(), "")
        .figure("centres", "centres", counts.centre_len, "")
        .figure("terms", "polynomial terms", counts.term_len, "")
        .figure("metric_rows", "rows of the metric", counts.metric_len, "")
        .figure("query_numbers", "numbers of a query", map.query_len(), "")
        .figure("result_numbers", "numbers of a result", map.result_len(), "")
        .figure("scratch_bytes", "scratch", 4 * counts.scratch_len(), "bytes")
        .part("fit", fit)
        .list("inputs", inputs)
        .list("outputs", outputs)
}

fn of_prior(prior: &Prior<'_>) -> Report {
    let (counts, fit) = (prior.counts(), prior.fit());
    let learned = match fit.frames > 0.0 {
        true => format!("from {} frames", fit.frames),
        false => "from no take".to_owned(),
    };
    let scratch = 8 * counts.pin_scratch_len(24);
    Report::of_part("prior", prior.part(), prior.name())
        .figure("skin", "part of the skin", counts.skin, "")
        .figure("shapes", "shapes", counts.shape_len, "")
        .shown("frames", "learned", fit.frames, learned)
        .figure("tolerance", "tolerance of pins", f64::from(fit.beta).sqrt(), "units")
        .figure("error", "error with a few landmarks", fit.error, "units")
        .figure("slider_error", "error of the slider norm", fit.slider_error, "units")
        .figure("mirrored_pairs", "mirrored pairs of shapes", counts.symmetry_len, "")
        .figure("cancelling_pairs", "cancelling pairs of shapes", counts.cancel_len, "")
        .figure("scratch_bytes_for_8_pins", "scratch for 8 pins", scratch, "bytes")
}

fn of_filter(filter: &Filter<'_>) -> Report {
    let FilterFit { step, left_out_rms, linear_rms } = filter.fit();
    let fit = Report::default()
        .figure("step", "step of the samples", step, "")
        .figure("left_out_rms", "samples left out, RMS error", left_out_rms, "")
        .figure("linear_rms", "by lines between samples", linear_rms, "");
    Report::of_part("filter", filter.part(), filter.name())
        .figure("factor", "phases", filter.factor(), "")
        .figure("taps", "taps of a phase", filter.tap_len(), "")
        .figure("variances", "variances", filter.variance(0, 0).is_some(), "")
        .part("fit", fit)
}

fn of_views(views: &Views<'_>) -> Report {
    let (counts, fit) = (views.counts(), views.fit());
    let names: Vec<_> = (0..).map_while(|view| views.view_name(view)).collect();
    Report::of_part("views", views.part(), views.name())
        .figure("points", "points", views.point_len(), "")
        .figure("elements", "elements", views.element_len(), "")
        .shown("key_views", "key views", &names, names.len().to_string())
        .figure("maps", "maps", counts.map_len, "")
        .figure("textures", "textures", counts.texture_len, "")
        .figure("transferred", "motion of another object", views.is_transferred(), "")
        .figure("rms", "points at the examples, RMS", fit.rms_error, "px")
        .figure("left_out_rms", "examples left out, RMS", fit.left_out_rms, "px")
        .figure("visibility", "share of points rightly visible", fit.visibility, "")
        .list("layers", (0..).map_while(|layer| Some(of_layer(views, layer, views.layer(layer)?))))
}

/// Describes a layer: the points that move it, its elements, and the key views that show it.
fn of_layer(views: &Views<'_>, number: usize, layer: Layer) -> Report {
    let elements = (layer.first..layer.end).filter_map(|element| views.element(element));
    let vertices: BTreeSet<usize> =
        elements.flat_map(|element| element.vertices().to_vec()).collect();
    let vertices = vertices.into_iter().filter_map(|vertex| views.vertex(vertex));
    let points: BTreeSet<usize> =
        vertices.flat_map(|vertex| vertex.weights().map(|(point, _)| point)).collect();
    let is_shown = |key: &usize| views.view_texture(*key, number).is_some();
    let key_views = (0..views.view_len()).filter(is_shown).count();
    let clip = layer.clip.and_then(|clip| views.layer_name(clip));
    Report::default()
        .figure("name", "layer", views.layer_name(number).unwrap_or_default(), "")
        .figure("points", "points", points.len(), "")
        .figure("elements", "elements", layer.end - layer.first, "")
        .figure("key_views", "key views", key_views, "")
        .figure("clip", "clipped by", clip, "")
}
