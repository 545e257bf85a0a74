//! What `sinew inspect` says of objects of views.

use crate::cli::described::Described;
use crate::cli::{counted, printable};
use serde_json::{Value, json};
use sinew_runtime::Model;
use sinew_runtime::format::PartKind;
use sinew_runtime::views::Views;

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
    out
}

fn as_json(views: &Views<'_>) -> Value {
    let (counts, fit) = (views.counts(), views.fit());
    json!({
        "name": views.name(),
        "points": views.point_len(),
        "elements": views.element_len(),
        "key_views": (0..).map_while(|view| views.view_name(view)).collect::<Vec<_>>(),
        "maps": counts.map_len,
        "textures": counts.texture_len,
        "transferred": views.is_transferred(),
        "rms": fit.rms_error,
        "left_out_rms": fit.left_out_rms,
        "visibility": fit.visibility,
    })
}
