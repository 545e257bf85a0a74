//! A page about an object: a sheet of views, the parts of a view, and networks over pixels for comparison.

use super::control::{NETWORKS, bytes, mixed, network_weights, pictures};
use super::player::{Played, Player, straight};
use super::set::{Examples, Values, View, ViewSet};
use crate::Error;
use crate::numeric::columns::ends;
use crate::page::camera::Resolution;
use crate::page::colour::Colour;
use crate::page::drawing::{Anchor, Drawing};
use crate::page::html::{figure, page, paragraph, section, side_by_side, table, text};
use crate::page::picture::Picture;
use sinew_runtime::views::{Element, Layer};
use sinew_runtime::{Model, Views};

/// Columns and rows of a sheet.
const STEPS: [usize; 2] = [7, 5];
/// Gap around each picture of a sheet, and height of its label, pixels.
const GAP: usize = 6;
const FOOT: usize = 20;
/// Approximate number of parameters at which an object and its prototype are drawn.
const LENT: usize = 3;
/// Largest number of pictures of layers in a row.
const MOST_ACROSS: usize = 4;
/// Colour of the edges of elements.
const EDGE: Colour = [0xbd, 0x2b, 0x44];

/// Makes the page of a file and its training views.
///
/// - `prototype`: the file that was trained on the views, if it lent its motion.
///
/// # Errors
/// The file has no map of a motion; a view cannot be drawn; a picture cannot be read, is damaged, or cannot be encoded.
pub fn report(
    model: &Model<Vec<u8>>,
    set: &ViewSet,
    prototype: Option<&Model<Vec<u8>>>,
) -> Result<String, Error> {
    let is_lent = model.first::<Views>().is_some_and(|views| views.is_transferred());
    let mut body = format!("<h1>{}</h1>\n", text(&set.name));
    if set.layers.len() > 1 {
        body += &section("Layers", &layers(model, set));
    }
    for examples in &set.maps {
        let name = format!("Views of \"{}\"", examples.name);
        let player = Player::new(model, Some(&examples.name))?;
        let sheet = sheet(&player, examples)?;
        let along: Vec<String> =
            axes(examples).into_iter().flatten().map(|axis| axis.name).collect();
        let framed = match is_lent {
            false => "framed views are examples, all others are made of them",
            true => "framed views are at the parameters of the prototype's examples",
        };
        let about = format!("{}: {framed}.", along.join(" by "));
        body += &section(&name, &(figure(&sheet, &name, "", "")? + &paragraph(&text(&about))));
        body += &section("What a view is made of", &made_of(&player, examples)?);
        if let Some(prototype) = prototype {
            let prototype = Player::new(prototype, Some(&examples.name))?;
            body += &section("The motion that is lent", &lent(&player, &prototype, examples)?);
        }
        if is_lent {
            // The pictures of the set belong to the prototype.
            continue;
        }
        if let Some(networks) = networks(&player, set, examples)? {
            body += &section("A network over pixels", &networks);
        }
    }
    Ok(page(&set.name, &body))
}

/// A parameter that varies along a side of the sheet.
struct Along {
    name: String,
    ends: [f64; 2],
    steps: usize,
}

/// Selects the first two parameters that vary.
fn axes(examples: &Examples) -> [Option<Along>; 2] {
    let names = examples.parameters.iter().flat_map(|parameter| parameter.names());
    let mut changing = names.filter_map(|name| {
        let values: Vec<f64> =
            examples.train.iter().filter_map(|view| view.values.get(name).copied()).collect();
        let ends = ends(&values);
        (ends[0] < ends[1]).then(|| (name.to_owned(), ends))
    });
    STEPS.map(|steps| changing.next().map(|(name, ends)| Along { name, ends, steps }))
}

fn sheet(player: &Player<'_>, examples: &Examples) -> Result<Picture, Error> {
    let [across, down] = axes(examples);
    let count = |axis: &Option<Along>| axis.as_ref().map_or(1, |axis| axis.steps);
    let [columns, rows] = [count(&across), count(&down)];
    let [width, height] = player.size();
    let cell = [width + GAP, height + GAP + FOOT];
    let mut out = Drawing::new(columns * cell[0] + GAP, rows * cell[1] + GAP);
    let start = examples.train.first().map(|view| view.values.clone()).unwrap_or_default();
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let mut values = start.clone();
        for (axis, step) in [(&across, column), (&down, row)] {
            if let Some(Along { name, ends: [low, high], steps }) = axis {
                let share = step as f64 / (steps - 1) as f64;
                values.insert(name.clone(), low + share * (high - low));
            }
        }
        let (picture, _) = shown(player, &values)?;
        let corner = [(GAP + column * cell[0]) as f64, (GAP + row * cell[1]) as f64];
        out.image(corner, picture.on_white());
        let near = |(name, value): (&String, &f64)| {
            values.get(name).is_some_and(|own| (own - value).abs() < 1e-9)
        };
        if examples.train.iter().any(|view| view.values.iter().all(near)) {
            out.frame(corner, [width as f64, height as f64]);
        }
        let named = [&across, &down].into_iter().flatten();
        let label: Vec<String> =
            named.map(|axis| format!("{:.2}", values.get(&axis.name).unwrap_or(&0.0))).collect();
        let foot = [corner[0] + 0.5 * width as f64, corner[1] + (height + FOOT - GAP) as f64];
        out.text(foot, Anchor::Middle, &label.join(" "));
    }
    Ok(out.picture())
}

/// Draws the object at parameters.
fn shown(player: &Player<'_>, values: &Values) -> Result<(Picture, Played), Error> {
    let played = player.play(values)?;
    Ok((straight(&player.draw(&played)?.0), played))
}

/// Returns the parameters halfway between the first two views.
fn between<'a>(mut views: impl Iterator<Item = &'a View>) -> Values {
    let Some(first) = views.next() else { return Values::new() };
    let other = views.next().unwrap_or(first);
    let middle = |(name, a): (&String, &f64)| {
        (name.clone(), 0.5 * (a + other.values.get(name).unwrap_or(a)))
    };
    first.values.iter().map(middle).collect()
}

/// Draws the layers of a key view and the view made of them, each with its elements.
fn made_of(player: &Player<'_>, examples: &Examples) -> Result<String, Error> {
    let (picture, played) = shown(player, &between(examples.train.iter()))?;
    let views = player.views();
    let elements = player.elements();
    let with_mesh = |picture: &Picture,
                     elements: &[Element],
                     at: &dyn Fn(usize) -> [f64; 2],
                     seen: &dyn Fn(usize) -> bool| {
        let Resolution { width, height } = picture.size;
        let mut out = Drawing::new(width, height);
        out.image([0.0; 2], picture.on_white());
        // Vertices that do not follow a single point are always drawn.
        let is_shown = |vertex: usize| {
            let point = views.vertex(vertex).and_then(|vertex| vertex.point());
            point.is_none_or(seen)
        };
        for element in elements.iter().map(Element::vertices) {
            if element.iter().all(|&vertex| is_shown(vertex)) {
                let ring = element.iter().chain(element.first()).map(|&vertex| at(vertex));
                out.line(ring.collect(), 0.7, EDGE);
            }
        }
        out.picture()
    };
    let mut figures = Vec::new();
    for (number, layer) in (0..).map_while(|number| Some((number, views.layer(number)?))) {
        let Some(source) = player.key_picture(played.view, number) else { continue };
        let own = elements.get(layer.first..layer.end).unwrap_or_default();
        let at = |vertex| views.texel(played.view, vertex).unwrap_or_default().map(f64::from);
        let seen = |point| views.is_visible(played.view, point) == Some(true);
        let name = match views.layer_len() {
            1 => "the key view".to_owned(),
            _ => views.layer_name(number).unwrap_or_default().to_owned(),
        };
        figures.push(figure(&with_mesh(&source, own, &at, &seen), &name, "", &text(&name))?);
    }
    let vertices = player.vertices(&played);
    let at = |vertex: usize| {
        let [x, y, _] = vertices[vertex].map(f64::from);
        [x, y]
    };
    let seen = |point: usize| played.visibility[point] > 0.5;
    let moved = with_mesh(&picture, &elements, &at, &seen);
    figures.push(figure(&moved, "its elements moved", "", "its elements moved")?);
    figures.push(figure(&picture, "the view", "", "the view that is made of them")?);
    Ok(side_by_side(figures.len().min(MOST_ACROSS), &figures))
}

/// Makes a table of the layers: points, elements, key views with a picture, and the clipping layer.
fn layers(model: &Model<Vec<u8>>, set: &ViewSet) -> String {
    let Some(views) = model.first::<Views>() else { return String::new() };
    let keys = views.view_len();
    let row = |(number, layer): (usize, Layer)| {
        let shown = (0..keys).filter(|&key| views.view_texture(key, number).is_some()).count();
        let name = |layer| text(views.layer_name(layer).unwrap_or_default());
        vec![
            name(number),
            set.layers.get(number).map_or(0, |own| own.points.len()).to_string(),
            (layer.end - layer.first).to_string(),
            format!("{shown} of {keys}"),
            layer.clip.map(name).unwrap_or_default(),
        ]
    };
    let all = (0..).map_while(|number| Some((number, views.layer(number)?)));
    let head = ["layer", "points", "elements", "key views", "clipped by"].map(str::to_owned);
    table(&head, &all.map(row).collect::<Vec<_>>())
}

/// Draws an object and its prototype: their pictures, then both at training parameters.
fn lent(object: &Player<'_>, prototype: &Player<'_>, examples: &Examples) -> Result<String, Error> {
    let both = [("the prototype", prototype), ("the object", object)];
    let mut figures = Vec::new();
    let named = object.views().view_name(0);
    for (name, player) in both {
        let views = player.views();
        let mut numbers = 0..views.view_len();
        let number = numbers.find(|&view| views.view_name(view) == named).unwrap_or_default();
        if let Some(picture) = player.key_picture(number, 0) {
            figures.push(figure(&picture, name, "", &format!("{name}, before"))?);
        }
    }
    let step = examples.train.len().div_ceil(LENT).max(1);
    for view in examples.train.iter().skip(step / 2).step_by(step) {
        let at: Vec<String> =
            view.values.iter().map(|(name, value)| format!("{name} {value}")).collect();
        for (name, player) in both {
            let caption = format!("{name} at {}", at.join(", "));
            let (picture, _) = shown(player, &view.values)?;
            figures.push(figure(&picture, &caption, "", &text(&caption))?);
        }
    }
    Ok(side_by_side(4, &figures))
}

/// Draws networks over pixels halfway between training views, beside points and warping. `None` if the map has fewer
/// than four pictures.
fn networks(
    player: &Player<'_>,
    set: &ViewSet,
    examples: &Examples,
) -> Result<Option<String>, Error> {
    let own: Vec<&View> = examples.train.iter().filter(|view| view.image.is_some()).collect();
    if own.len() < 4 {
        return Ok(None);
    }
    let values = between(own.iter().copied());
    let (picture, _) = shown(player, &values)?;
    let all = pictures(&own, set.size)?;
    let at = View { values, ..own[0].clone() };
    let mut figures = vec![figure(&picture, "points and warping", "", "points and warping")?];
    for (kernel, epsilon) in NETWORKS {
        let Ok(weights) = network_weights((kernel, epsilon), &examples.parameters, &own, &at)
        else {
            continue;
        };
        let rgba = bytes(&mixed(&weights, &all));
        let mixed = straight(&Picture { size: picture.size, rgba });
        let name = format!("{}, width {:.2}", kernel.name(), 1.0 / epsilon);
        figures.push(figure(&mixed, &name, "", &name)?);
    }
    Ok(Some(side_by_side(4, &figures)))
}
