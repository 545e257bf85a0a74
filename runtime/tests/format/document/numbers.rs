//! Counts and figures of parts.

use super::assert_fields;
use sinew_runtime::envelope::{Certificate, EnvelopeCounts};
use sinew_runtime::filter::{FilterCounts, FilterFit};
use sinew_runtime::kernel::{KernelCounts, KernelFit};
use sinew_runtime::prior::{PriorCounts, PriorFit};
use sinew_runtime::record::RecordCounts;
use sinew_runtime::skin::SkinCounts;
use sinew_runtime::views::{ViewsCounts, ViewsFit};

#[test]
fn the_document_lays_the_numbers_of_a_kernel_out_as_the_code() {
    let words: [u32; 8] = [11, 12, 13, 14, 15, 16, 17, 18];
    let counts = KernelCounts::from_words(words);
    assert_eq!(counts.words(), words);
    let fields = [
        ("input_len", counts.input_len.into()),
        ("output_len", counts.output_len.into()),
        ("feature_len", counts.feature_len.into()),
        ("metric_len", counts.metric_len.into()),
        ("centre_len", counts.centre_len.into()),
        ("term_len", counts.term_len.into()),
        ("value_len", counts.value_len.into()),
        ("variance_len", counts.variance_len.into()),
    ];
    let bytes = words.map(u32::to_le_bytes);
    assert_eq!(bytes.as_flattened().len(), KernelCounts::BYTES);
    assert_fields("Counts of a kernel", bytes.as_flattened(), &fields);

    let figures = [1.0, 2.0, 3.0, 4.0];
    let fit = KernelFit::from_figures(figures);
    assert_eq!(fit.figures(), figures);
    let bits = |x: f32| u64::from(x.to_bits());
    let fields = [
        ("rms_residual", bits(fit.rms_residual)),
        ("left_out_rms", bits(fit.left_out_rms)),
        ("rounding_error", bits(fit.rounding_error)),
        ("reciprocal_condition", bits(fit.reciprocal_condition)),
    ];
    let bytes = figures.map(f32::to_le_bytes);
    assert_fields("Fit of a kernel", bytes.as_flattened(), &fields);
}

#[test]
fn the_document_lays_the_numbers_of_a_prior_out_as_the_code() {
    let words: [u32; 4] = [11, 12, 13, 14];
    let counts = PriorCounts::from_words(words);
    assert_eq!(counts.words(), words);
    let fields = [
        ("skin", counts.skin.into()),
        ("shape_len", counts.shape_len.into()),
        ("symmetry_len", counts.symmetry_len.into()),
        ("cancel_len", counts.cancel_len.into()),
    ];
    let bytes = words.map(u32::to_le_bytes);
    assert_eq!(bytes.as_flattened().len(), PriorCounts::BYTES);
    assert_fields("Counts of a prior", bytes.as_flattened(), &fields);

    let figures = [1.0, 2.0, 3.0, 4.0];
    let fit = PriorFit::from_figures(figures);
    assert_eq!(fit.figures(), figures);
    let bits = |x: f32| u64::from(x.to_bits());
    let fields = [
        ("beta", bits(fit.beta)),
        ("frames", bits(fit.frames)),
        ("error", bits(fit.error)),
        ("slider_error", bits(fit.slider_error)),
    ];
    let bytes = figures.map(f32::to_le_bytes);
    assert_fields("Fit of a prior", bytes.as_flattened(), &fields);
}

#[test]
fn the_document_lays_the_numbers_of_views_out_as_the_code() {
    let words: [u32; 11] = [11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21];
    let counts = ViewsCounts::from_words(words);
    assert_eq!(counts.words(), words);
    let fields = [
        ("point_len", counts.point_len.into()),
        ("vertex_len", counts.vertex_len.into()),
        ("weight_len", counts.weight_len.into()),
        ("element_len", counts.element_len.into()),
        ("layer_len", counts.layer_len.into()),
        ("view_len", counts.view_len.into()),
        ("map_len", counts.map_len.into()),
        ("texture_len", counts.texture_len.into()),
        ("texel_len", counts.texel_len.into()),
        ("width", counts.size[0].into()),
        ("height", counts.size[1].into()),
    ];
    let bytes = words.map(u32::to_le_bytes);
    assert_eq!(bytes.as_flattened().len(), ViewsCounts::BYTES);
    assert_fields("Counts of views", bytes.as_flattened(), &fields);

    let figures = [1.0, 2.0, 3.0];
    let fit = ViewsFit::from_figures(figures);
    assert_eq!(fit.figures(), figures);
    let bits = |x: f32| u64::from(x.to_bits());
    let fields = [
        ("rms_error", bits(fit.rms_error)),
        ("left_out_rms", bits(fit.left_out_rms)),
        ("visibility", bits(fit.visibility)),
    ];
    let bytes = figures.map(f32::to_le_bytes);
    assert_fields("Fit of views", bytes.as_flattened(), &fields);
}

#[test]
fn the_document_lays_the_numbers_of_a_filter_out_as_the_code() {
    let words: [u32; 2] = [11, 12];
    let counts = FilterCounts::from_words(words);
    assert_eq!(counts.words(), words);
    let fields = [("factor", counts.factor.into()), ("tap_len", counts.tap_len.into())];
    let bytes = words.map(u32::to_le_bytes);
    assert_eq!(bytes.as_flattened().len(), FilterCounts::BYTES);
    assert_fields("Counts of a filter", bytes.as_flattened(), &fields);

    let figures = [1.0, 2.0, 3.0];
    let fit = FilterFit::from_figures(figures);
    assert_eq!(fit.figures(), figures);
    let bits = |x: f32| u64::from(x.to_bits());
    let fields = [
        ("step", bits(fit.step)),
        ("left_out_rms", bits(fit.left_out_rms)),
        ("linear_rms", bits(fit.linear_rms)),
    ];
    let bytes = figures.map(f32::to_le_bytes);
    assert_fields("Fit of a filter", bytes.as_flattened(), &fields);
}

#[test]
fn the_document_lays_the_counts_of_a_record_out_as_the_code() {
    let words: [u32; 4] = [11, 12, 13, 14];
    let counts = RecordCounts::from_words(words);
    assert_eq!(counts.words(), words);
    let fields = [
        ("frame_len", counts.frame_len.into()),
        ("vertex_len", counts.vertex_len.into()),
        ("influence_len", counts.influence_len.into()),
        ("joint_len", counts.joint_len.into()),
    ];
    let bytes = words.map(u32::to_le_bytes);
    assert_eq!(bytes.as_flattened().len(), RecordCounts::BYTES);
    assert_fields("Counts of a record", bytes.as_flattened(), &fields);
}

#[test]
fn the_document_lays_counts_out_as_the_code() {
    let words: [u32; 8] = [4, 11, 12, 13, 14, 15, 1, 17];
    let counts = EnvelopeCounts::from_words(words).unwrap();
    assert_eq!(counts.words(), words);
    let fields = [
        ("predictor", u64::from(counts.predictor.number() + counts.helper_kind.number())),
        ("joint_len", counts.joint_len.into()),
        ("proxy_len", counts.proxy_len.into()),
        ("root", counts.root.into()),
        ("group_len", counts.group_len.into()),
        ("correction_len", counts.correction_len.into()),
        ("stretches", counts.stretches.into()),
        ("curve_len", counts.curve_len.into()),
    ];
    let bytes = words.map(u32::to_le_bytes);
    assert_eq!(bytes.as_flattened().len(), EnvelopeCounts::BYTES);
    assert_fields("Counts of an envelope", bytes.as_flattened(), &fields);

    let words: [u32; 7] = [11, 12, 13, 14, 15, 16, 17];
    let counts = SkinCounts::from_words(words);
    assert_eq!(counts.words(), words);
    let fields = [
        ("vertex_len", counts.vertex_len.into()),
        ("influence_len", counts.influence_len.into()),
        ("envelope", counts.envelope.into()),
        ("range_len", counts.range_len.into()),
        ("shape_len", counts.shape_len.into()),
        ("entry_len", counts.entry_len.into()),
        ("delta_len", counts.delta_len.into()),
    ];
    let bytes = words.map(u32::to_le_bytes);
    assert_eq!(bytes.as_flattened().len(), SkinCounts::BYTES);
    assert_fields("Counts of a skin", bytes.as_flattened(), &fields);

    let figures = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
    let certificate = Certificate::from_figures(figures);
    assert_eq!(certificate.figures(), figures);
    let bits = |x: f32| u64::from(x.to_bits());
    let fields = [
        ("diagonal", bits(certificate.diagonal)),
        ("training_rms", bits(certificate.training_rms)),
        ("same_clips_rms", bits(certificate.same_clips_rms)),
        ("lbs_training_rms", bits(certificate.lbs_training_rms)),
        ("correction_error", bits(certificate.correction_error)),
        ("base_training_rms", bits(certificate.base_training_rms)),
        ("other_clip_rms", bits(certificate.other_clip_rms.unwrap_or(-1.0))),
        ("trs_error", bits(certificate.trs_error)),
    ];
    let bytes = figures.map(f32::to_le_bytes);
    assert_eq!(bytes.as_flattened().len(), Certificate::BYTES);
    assert_fields("Certificate", bytes.as_flattened(), &fields);
}
