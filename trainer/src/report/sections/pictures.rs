//! Sections made of pictures.

use crate::Error;
use crate::evaluate::{Character, Errors, Measured, OWN_WEIGHTS};
use crate::examples::Examples;
use crate::numeric::columns::largest;
use crate::page::camera::Camera;
use crate::page::colour::{Colour, Scale, distinct_colours};
use crate::page::html::{grouped, paragraph, side_by_side, text};
use crate::report::comparison::{Comparison, Series};
use crate::report::pictures::{Paint, Pictures, Shape};
use crate::space::written;
use sinew_runtime::{Envelope, Skin};
use std::collections::BTreeSet;

const SCALES: &str = "Colours show errors in % of the diagonal. All pictures share one scale, except the last, which \
                      shows the model once more on a separate scale. The ring is the worst \
                      vertex, broken where it is hidden.";
/// Units of the colours of distances and of angles.
const PERCENT: &str = "% of the diagonal";
const DEGREES: &str = "degrees";
/// Colours of near-rigid vertices and of other vertices.
const NEAR_RIGID: [Colour; 2] = [[0xd9, 0xa4, 0x4a], [0xdd, 0xd9, 0xd2]];

/// The truth and every skin in the model's worst frame, with the errors below; then a close-up of the worst vertex.
pub(super) fn worst_pose(pictures: &Pictures<'_>) -> Result<String, Error> {
    let comparison = pictures.comparison;
    let series = comparison.series();
    let frame = &comparison.model.measured.frames[pictures.worst];
    let shapes = pictures.frame(frame.frame, &series)?;
    let vertex = frame.worst_vertex();
    let errors: Vec<_> = series.iter().map(|s| s.measured.percent_in(pictures.worst)).collect();
    let rows = |camera: &Camera| -> Result<String, Error> {
        let clay = shapes.iter().map(|s| pictures.take(s, &Paint::Clay, camera, None, &s.name));
        let clay = clay.collect::<Result<Vec<_>, _>>()?;
        let heat = heat(pictures, &errors, |place| &shapes[place + 1], camera, Some(vertex))?;
        // Each error map is below its skin; the place below the truth is empty.
        let truth = std::iter::once("<div></div>\n".to_owned());
        let under: Vec<String> = truth.chain(heat).collect();
        Ok(side_by_side(under.len(), &clay) + &side_by_side(under.len(), &under))
    };
    let error = |s: &Series<'_>| {
        let rms = s.measured.errors_in(pictures.worst).rms_percent;
        format!("{}: {}", text(s.name), comparison.length(rms))
    };
    let series_errors: Vec<String> = series.iter().map(error).collect();
    let model = comparison.model_place();
    let baselines = ["LBS", OWN_WEIGHTS].into_iter().zip(&errors[..model]);
    let baselines =
        baselines.map(|(name, errors)| format!("{name} by {}", comparison.length(errors[vertex])));
    let baselines: Vec<String> = baselines.collect();
    let camera = pictures.whole(&shapes.iter().collect::<Vec<_>>());
    let angles: Vec<_> = series.iter().map(|s| s.measured.degrees_in(pictures.worst)).collect();
    let summed = series.iter().map(|s| s.measured.errors_in(pictures.worst));
    let angles = angle_maps(pictures, &angles, summed, |place| &shapes[place + 1], &camera)?;
    Ok(paragraph(&format!(
        "The frame with the model's largest RMS error. {}. {SCALES}",
        series_errors.join("; ")
    )) + &rows(&camera)?
        + &angles
        + "<h3>Around the worst vertex</h3>\n"
        + &paragraph(&format!(
            "Vertex {vertex}, where the model is off by {}, {}.",
            comparison.length(errors[model][vertex]),
            baselines.join(", ")
        ))
        + &rows(&pictures.near(&shapes[0], vertex, &errors[model]))?)
}

/// The rest pose, and each vertex's error over all measured frames on the rest pose.
pub(super) fn all_frames(pictures: &Pictures<'_>) -> Result<String, Error> {
    let comparison = pictures.comparison;
    let (rest, series) = (pictures.rest(), comparison.series());
    let camera = pictures.whole(&[&rest]);
    let errors: Vec<_> = series.iter().map(|s| s.measured.vertex_rms_percent()).collect();
    let mut row = heat(pictures, &errors, |_| &rest, &camera, None)?;
    row.insert(0, pictures.take(&rest, &Paint::Clay, &camera, None, "rest pose")?);
    let angles: Vec<_> = series.iter().map(|s| s.measured.vertex_rms_degrees()).collect();
    let summed = series.iter().map(|s| s.measured.errors());
    let angles = angle_maps(pictures, &angles, summed, |_| &rest, &camera)?;
    Ok(paragraph(&format!(
        "Each vertex's RMS error over the {} measured frames, on the rest pose.",
        grouped(comparison.model.measured.frames.len())
    )) + &side_by_side(row.len(), &row)
        + &worst_vertices(comparison, &errors[comparison.model_place()])
        + &angles)
}

/// The errors of every series on one scale, then of the model on a separate scale.
fn heat<'b>(
    pictures: &Pictures<'_>,
    errors: &[Vec<f64>],
    shape: impl Fn(usize) -> &'b Shape,
    camera: &Camera,
    ring: Option<usize>,
) -> Result<Vec<String>, Error> {
    let comparison = pictures.comparison;
    let (series, model) = (comparison.series(), comparison.model_place());
    let (own, common) = (Scale::of(&errors[model]), Scale::of(errors.iter().flatten()));
    let all = (0..series.len()).map(|place| (place, common, "error, %"));
    let all = all.chain([(model, own, "on a separate scale, %")]);
    let pictures = all.map(|(place, scale, what)| {
        let caption = format!("{}: {what}", series[place].name);
        let paint = Paint::Heat(&errors[place], scale, PERCENT);
        pictures.take(shape(place), &paint, camera, ring, &caption)
    });
    pictures.collect()
}

/// The angles between every series' normals and the true normals, on one scale up to the largest 99th percentile.
fn angle_maps<'b>(
    pictures: &Pictures<'_>,
    degrees: &[Vec<f64>],
    errors: impl Iterator<Item = Errors>,
    shape: impl Fn(usize) -> &'b Shape,
    camera: &Camera,
) -> Result<String, Error> {
    let scale = Scale::of(&errors.map(|own| own.normal_p99_degrees).collect::<Vec<_>>());
    let series = pictures.comparison.series();
    let maps = series.iter().enumerate().map(|(place, series)| {
        let caption = format!("{}: angle of the normals to the true ones, °", series.name);
        let paint = Paint::Heat(&degrees[place], scale, DEGREES);
        pictures.take(shape(place), &paint, camera, None, &caption)
    });
    let maps = maps.collect::<Result<Vec<_>, _>>()?;
    Ok(paragraph(
        "Angles between the normals and the true normals, all on one scale; larger angles in folds have the \
         last colour.",
    ) + &side_by_side(maps.len().max(3), &maps))
}

fn worst_vertices(comparison: &Comparison<'_>, errors: &[f64]) -> String {
    const MOST: usize = 5;
    let mut order: Vec<usize> = (0..errors.len()).collect();
    order.sort_by(|&a, &b| errors[b].total_cmp(&errors[a]));
    let worst = order.iter().take(MOST).map(|&vertex| {
        let frame = comparison.source.number(worst_frame(&comparison.model.measured, vertex));
        let error = errors[vertex];
        let mm = comparison.mm(error).map_or(String::new(), |mm| format!(", {} mm", written(mm)));
        format!("{vertex} ({error:.4} %{mm}, worst in frame {frame})")
    });
    let worst: Vec<String> = worst.collect();
    paragraph(&format!("The vertices with the largest: {}.", worst.join(", ")))
}

fn worst_frame(measured: &Measured, vertex: usize) -> usize {
    let distances: Vec<f64> = measured.frames.iter().map(|f| f.distances[vertex]).collect();
    measured.frames[largest(&distances)].frame
}

/// The palette: near-rigid vertices, and the transform that each vertex follows most.
pub(super) fn palette(
    pictures: &Pictures<'_>,
    near_rigid: Option<&[bool]>,
) -> Result<String, Error> {
    let comparison = pictures.comparison;
    let (rest, examples) = (pictures.rest(), comparison.source.examples);
    let camera = pictures.whole(&[&rest]);
    let mut row = Vec::new();
    for (number, model) in comparison.models().enumerate() {
        let (name, alone) = (model.file.name, follow_joints(&model.character, examples));
        let (rigid, what) = match (&alone, near_rigid.filter(|_| number == 0)) {
            (Some(alone), _) => (Some(alone.as_slice()), "follow joints alone"),
            (None, given) => (given, "are near-rigid: the reconstruction holds them at LBS"),
        };
        // A picture with one colour shows nothing.
        if let Some(rigid) = rigid.filter(|rigid| rigid.contains(&true) && rigid.contains(&false)) {
            let colours: Vec<Colour> =
                rigid.iter().map(|&rigid| NEAR_RIGID[usize::from(!rigid)]).collect();
            let paint = Paint::Kinds(&colours);
            let count = rigid.iter().filter(|rigid| **rigid).count();
            let share = 100.0 * count as f64 / rigid.len().max(1) as f64;
            let caption = format!("{name}: {} vertices ({share:.0} %) {what}", grouped(count));
            row.push(pictures.take(&rest, &paint, &camera, None, &caption)?);
        }
        let colours = dominant_colours(&model.character, examples);
        let caption = format!(
            "{name}: each vertex in the colour of the transform that it follows most, of {}",
            describe_palette(&model.character.envelope)
        );
        row.push(pictures.take(&rest, &Paint::Kinds(&colours), &camera, None, &caption)?);
    }
    Ok(side_by_side(row.len().max(3), &row))
}

fn describe_palette(envelope: &Envelope<'_>) -> String {
    let proxies = envelope.proxy_len();
    match envelope.palette_len() - proxies {
        0 => format!("{proxies} helpers"),
        joints => format!("{joints} joints and {proxies} helpers"),
    }
}

/// Colours each vertex by the transform that it follows most. Transforms that meet on the surface have different hues.
fn dominant_colours(character: &Character<'_>, examples: &Examples) -> Vec<Colour> {
    let firsts = examples.surface().first_copies().into_iter();
    let dominant: Vec<usize> = firsts.map(|copy| strongest(&character.skin, copy)).collect();
    let mut meet = vec![BTreeSet::new(); character.skin.palette_len()];
    for corners in &examples.triangles {
        let own = corners.map(|vertex| dominant[vertex]);
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            if own[a] != own[b] {
                meet[own[a]].insert(own[b]);
                meet[own[b]].insert(own[a]);
            }
        }
    }
    let neighbours: Vec<Vec<usize>> = meet.into_iter().map(Vec::from_iter).collect();
    let colours = distinct_colours(&neighbours);
    dominant.into_iter().map(|index| colours[index]).collect()
}

/// Marks the V vertices of a kernel model that follow only joints; `None` for a palette without joints.
fn follow_joints(character: &Character<'_>, examples: &Examples) -> Option<Vec<bool>> {
    let Character { envelope, skin, .. } = character;
    let joints = envelope.palette_len() - envelope.proxy_len();
    let alone =
        |vertex| skin.influences(vertex).all(|(index, weight)| index < joints || weight == 0.0);
    let firsts = examples.surface().first_copies().into_iter();
    (joints > 0).then(|| firsts.map(alone).collect())
}

fn strongest(skin: &Skin<'_>, vertex: usize) -> usize {
    let all = skin.influences(vertex);
    all.fold((0, 0.0), |best, next| if next.1 > best.1 { next } else { best }).0
}
