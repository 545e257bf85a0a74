//! The matrix reports every failure, in every format.

use crate::devices::software::{Fault, Software};
use ::models::{FilterContent, KernelContent, Pieces, ShapeContent};
use conformance::backend::Loaded;
use conformance::filters::FilterSubject;
use conformance::kernels::KernelSubject;
use conformance::matrix::{Matrix, Scope, markdown, page};
use conformance::models::{self, shape_of};
use conformance::shapes::ShapeSubject;
use conformance::subject::Subject;
use sinew_gpu::headless::{Device, HeadlessError};
use sinew_gpu::layout::{Resource, Stage};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::Element;

/// Measures one model of one predictor; the stages of the other predictor have nothing to compare.
fn matrix(fault: Option<Fault>) -> Matrix {
    let random = models::random(shape_of(Predictor::Rotational));
    let mut pieces = Pieces::of(&random).expect("a random model is sound");
    pieces.append(Pieces::kernels(&[KernelContent::servo()]));
    let vertex_len = Loaded::new(&random).skin.vertex_len();
    pieces.set_shapes(&ShapeContent::sample(Element::F16, 3, vertex_len));
    pieces.add_filter(&FilterContent::sample(2, 5));
    let bytes = pieces.bytes();
    let scope = Scope {
        subjects: vec![Subject::new("random", &bytes, 14)],
        kernels: vec![KernelSubject::new(&bytes, 14)],
        shaped: vec![ShapeSubject::new(&bytes, 5)],
        filters: vec![FilterSubject::new(&bytes, 2, 3)],
    };
    let mut out = Matrix::new(&scope);
    let mut device = Software::new(&bytes, fault);
    device.info.name = "<b>evil | device\n</b>".to_owned();
    out.add(&device, &scope);
    out
}

#[test]
fn a_bit_is_counted_and_a_stage_left_out_fails() {
    let flipped = matrix(Some(Fault::Bit(Stage::Palette, Resource::Palettes, 4)));
    let row = |matrix: &Matrix, stage: &str| {
        let rows = &matrix.backends[1].stages;
        rows.iter().find(|row| row.stage == stage).unwrap().clone()
    };
    let palette = row(&flipped, "palette");
    assert_eq!((palette.differing, palette.failure.clone()), (1, None));
    assert!(palette.cases > 800 && palette.worst < 1.0);
    assert!(row(&flipped, "whole").differing >= 1, "the palette is an output there as well");
    assert_eq!(row(&flipped, "gradients").differing, 0);

    let idle = matrix(Some(Fault::Idle(Stage::Skin)));
    let skin = row(&idle, "skin");
    assert!(skin.worst == f64::INFINITY && skin.differing == skin.cases);
    assert!(skin.failure.unwrap().contains("NaN"));
    assert!(!idle.holds());

    let kernel = row(&matrix(Some(Fault::Bit(Stage::Kernel, Resource::Out, 5))), "kernel");
    assert_eq!((kernel.cases, kernel.differing, kernel.failure), (28, 1, None));

    let shapes = row(&matrix(Some(Fault::Idle(Stage::Shapes))), "shapes");
    assert!(shapes.cases > 1000 && shapes.failure.is_some());

    let filter = row(&matrix(Some(Fault::Bit(Stage::Filter, Resource::Out, 3))), "filter");
    assert_eq!((filter.cases, filter.differing, filter.failure), (144, 1, None));

    let stray = matrix(Some(Fault::Stray(Stage::Palette, Resource::Scratch, 0)));
    assert!(row(&stray, "palette").failure.unwrap().contains("which is not its own"));
}

#[test]
fn stages_that_no_model_has_fail() {
    let matrix = matrix(None);
    for column in &matrix.backends {
        let failing: Vec<_> = column.stages.iter().filter(|row| row.failure.is_some()).collect();
        let names: Vec<_> = failing.iter().map(|row| row.stage).collect();
        assert_eq!(names, ["polar", "joints", "features", "correction"]);
        assert!(failing.iter().all(|row| row.failure.as_deref() == Some("nothing was compared")));
    }
}

#[test]
fn names_of_drivers_cannot_become_markup() {
    let mut matrix = matrix(Some(Fault::Idle(Stage::Skin)));
    let bytes = models::random(shape_of(Predictor::Rotational));
    let lost = HeadlessError::Lost("<u>".to_owned());
    matrix.add_unopened(Software::new(&bytes, None).info(), &lost);
    let (text, html) = (markdown(&matrix), page(&matrix));
    assert!(text.contains("evil \\| device </b>") && text.contains(" ∞ **fails** |"));
    assert!(text.lines().filter(|line| line.starts_with("| ")).all(|line| line.ends_with('|')));
    assert!(html.contains("&lt;b&gt;evil") && !html.contains("<b>evil") && !html.contains("<u>"));
    assert!(html.contains("Not every stage holds") && html.contains("What fails"));
    let json: serde_json::Value =
        serde_json::from_str(&serde_json::to_string(&matrix).unwrap()).unwrap();
    let stages = json["backends"][1]["stages"].as_array().unwrap();
    let skin = stages.iter().find(|row| row["stage"] == "skin").unwrap();
    assert!(skin["worst"].is_null() && skin["failure"].is_string());
    assert_eq!(json["backends"][0]["api"], "cpu");
}
