//! Descriptions of objects of views for `sinew inspect`.

use crate::cli::described::Described;
use crate::cli::{counted, printable};
use serde::Serialize;
use serde_json::{Value, json};
use sinew_runtime::Model;
use sinew_runtime::format::PartKind;
use sinew_runtime::views::{Layer, Views};
use std::collections::BTreeSet;

/// Describes the objects of a file.
pub(in crate::cli) fn describe(model: &Model<Vec<u8>>) -> Vec<Described> {
    let described = |views: Views<'_>| Described {
        part: views.part(),
        kind: PartKind::Views,
        name: views.name().to_owned(),
        text: as_text(&views),
        json: as_json(&views),
    };
    model.all_views().map(described).collect()
}

fn as_text(views: &Views<'_>) -> String {
    let (counts, fit) = (views.counts(), views.fit());
    let mut out = format!(
        "views \"{}\": {}, {}, {}, {}{}\n",
        printable(views.name()),
        counted(views.point_len(), "point", "points"),
        counted(views.element_len(), "element", "elements"),
        counted(views.view_len(), "key view", "key views"),
        counted(counts.map_len as usize, "map", "maps"),
        if views.is_transferred() { ", lent motion" } else { "" },
    );
    for (name, figure) in [
        ("points at the examples, RMS px", fit.rms_error),
        ("examples left out, RMS px", fit.left_out_rms),
        ("visibility", fit.visibility),
    ] {
        out += &format!("  {name:<34}{figure:.3e}\n");
    }
    let layers = layers(views);
    for layer in layers.iter().filter(|_| layers.len() > 1) {
        let clip = layer.clip.map(|clip| format!(", clipped by \"{}\"", printable(clip)));
        out += &format!(
            "  layer \"{}\": {}, {}, {}{}\n",
            printable(layer.name),
            counted(layer.points, "point", "points"),
            counted(layer.elements, "element", "elements"),
            counted(layer.key_views, "key view", "key views"),
            clip.unwrap_or_default(),
        );
    }
    out
}

/// A layer of a file.
#[derive(Serialize)]
struct DescribedLayer<'a> {
    name: &'a str,
    /// Number of points that move the layer.
    points: usize,
    elements: usize,
    /// Number of key views that show the layer.
    key_views: usize,
    clip: Option<&'a str>,
}

fn layers<'a>(views: &Views<'a>) -> Vec<DescribedLayer<'a>> {
    let described = |(number, layer): (usize, Layer)| {
        let elements = (layer.first..layer.end).filter_map(|element| views.element(element));
        let vertices: BTreeSet<usize> =
            elements.flat_map(|element| element.vertices().to_vec()).collect();
        let vertices = vertices.into_iter().filter_map(|vertex| views.vertex(vertex));
        let points: BTreeSet<usize> =
            vertices.flat_map(|vertex| vertex.weights().map(|(point, _)| point)).collect();
        let is_shown = |key: &usize| views.view_texture(*key, number).is_some();
        DescribedLayer {
            name: views.layer_name(number).unwrap_or_default(),
            points: points.len(),
            elements: layer.end - layer.first,
            key_views: (0..views.view_len()).filter(is_shown).count(),
            clip: layer.clip.and_then(|clip| views.layer_name(clip)),
        }
    };
    (0..).map_while(|number| Some((number, views.layer(number)?))).map(described).collect()
}

fn as_json(views: &Views<'_>) -> Value {
    let (counts, fit) = (views.counts(), views.fit());
    json!({
        "name": views.name(),
        "points": views.point_len(),
        "elements": views.element_len(),
        "key_views": (0..).map_while(|view| views.view_name(view)).collect::<Vec<_>>(),
        "layers": layers(views),
        "maps": counts.map_len,
        "textures": counts.texture_len,
        "transferred": views.is_transferred(),
        "rms": fit.rms_error,
        "left_out_rms": fit.left_out_rms,
        "visibility": fit.visibility,
    })
}
