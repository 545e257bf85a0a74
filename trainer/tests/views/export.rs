//! Grids of parameters for other tools: an Inochi2D puppet, read by its own parser.

use super::common::Folder;
use super::flat::{draw, drawn, found, made as made_of, psnr};
use super::puppets::{binding, number, picture, posed, texels};
use inochi2d_parser::prelude::{BindingValues, Interpolation, Node, ParamName, PartData, Puppet};
use sinew_runtime::Model;
use sinew_trainer::ErrorKind;
use sinew_trainer::views::demo::write;
use sinew_trainer::views::export::{Grid, Node as GridNode, Side, puppet};
use sinew_trainer::views::fit::Shown;
use sinew_trainer::views::model::ViewsModel;
use sinew_trainer::views::player::Player;
use sinew_trainer::views::set::{Values, ViewSet, read};
use sinew_trainer::views::train::Trained;

/// Tolerance of single precision, pixels.
const ROUNDING: f64 = 1e-3;

/// Returns a set of the demo, the trained model, and its file.
fn made(folder: &Folder, name: &str) -> (ViewSet, Trained, Model<Vec<u8>>) {
    write(&folder.path("")).unwrap();
    let views = folder.path(name).join("views.json");
    let (trained, file) = made_of(&views);
    (read(&views, None).unwrap(), trained, file)
}

fn side(name: &str, range: Option<[f64; 2]>, nodes: usize) -> Side {
    Side { name: name.to_owned(), range, nodes }
}

/// Evaluates the model in double precision.
fn shown(trained: &Trained, values: &[(&str, f64)]) -> Shown {
    let values = values.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    trained.model.outputs().evaluate(&trained.model.maps[0], &values).unwrap()
}

/// Compares the mesh of a part with the model's vertices at each node, relative to the middle of the screen. Returns
/// the key view and the vertices of the part.
fn is_bent(
    part: (&Node, &PartData),
    puppet: &Puppet,
    model: &ViewsModel,
    nodes: &[(usize, usize, Shown)],
    middle: [f64; 2],
) -> (usize, Vec<usize>) {
    let (node, part) = part;
    let mesh = part.mesh.as_ref().unwrap();
    let bend = binding(puppet, node.uuid, &ParamName::Deform);
    assert_eq!(bend.interpolate_mode, Interpolation::Linear);
    let BindingValues::Deform(values) = &bend.values else { panic!("a mesh is bent") };
    let picture = picture(puppet, part);
    let (_, view, numbers) = found(model, &node.name, &picture, &texels(part, &picture));
    for (i, j, shown) in nodes {
        assert!(bend.is_set[*i][*j]);
        for (k, &vertex) in numbers.iter().enumerate() {
            let expected = model.mesh.vertices[vertex].at(&shown.points);
            let by = values.get(*i, j * numbers.len() + k).unwrap();
            for axis in 0..2 {
                let found = f64::from(mesh.vertices[2 * k + axis]) + f64::from(by[axis]);
                let expected = expected[axis] - middle[axis];
                assert!((found - expected).abs() < ROUNDING, "{found} {expected}");
            }
        }
    }
    (view, numbers)
}

#[test]
fn a_grid_of_two_parameters_is_a_puppet() {
    let folder = Folder::new("puppet");
    let (set, trained, file) = made(&folder, "panel");
    let sides = [side("yaw", None, 9), side("pitch", Some([-20.0, 20.0]), 5)];
    let bend: Values = [("bend".to_owned(), 0.25)].into();
    let grid = Grid::of_sides(&file, None, &bend, &sides).unwrap();
    let puppet = Puppet::from_bytes(&puppet(&file, None, &grid).unwrap()).unwrap();
    let parameter = puppet.params.values().next().unwrap();
    assert_eq!((puppet.params.len(), parameter.name.as_str()), (1, "yaw, pitch"));
    assert_eq!((parameter.min, parameter.max), ([-40.0, -20.0], [40.0, 20.0]));
    assert!(parameter.is_vec2 && parameter.defaults == [0.0, 0.0]);
    assert_eq!(parameter.axis_points[0][2], 0.25);
    assert_eq!(parameter.axis_points[1], [0.0, 0.25, 0.5, 0.75, 1.0]);
    let places = (0..9).flat_map(|i| (0..5).map(move |j| (i, j)));
    let nodes: Vec<(usize, usize, Shown)> = places
        .map(|(i, j)| {
            let (yaw, pitch) = (-40.0 + 10.0 * i as f64, -20.0 + 10.0 * j as f64);
            (i, j, shown(&trained, &[("yaw", yaw), ("pitch", pitch), ("bend", 0.25)]))
        })
        .collect();
    let parts: Vec<&Node> =
        puppet.nodes.iter().filter(|node| node.type_node.as_part().is_some()).collect();
    assert!(parts.len() >= 3 && puppet.textures.len() == parts.len());
    let key =
        |node: &Node| trained.model.keys.iter().position(|key| key.name == node.name).unwrap();
    for node in &parts {
        let part = node.type_node.as_part().unwrap();
        let (view, vertices) = is_bent((node, part), &puppet, &trained.model, &nodes, [96.0, 96.0]);
        assert_eq!((view, vertices.len()), (key(node), 35));
        let (mesh, key) = (part.mesh.as_ref().unwrap(), &trained.model.keys[view]);
        let (picture, corner) = key.pictures[0].as_ref().unwrap();
        for (k, &vertex) in vertices.iter().enumerate() {
            let place = trained.model.mesh.vertices[vertex].at(&key.points);
            for (axis, size) in [picture.size.width, picture.size.height].into_iter().enumerate() {
                let [rest, uv] =
                    [&mesh.vertices, &mesh.uvs].map(|all| f64::from(all[2 * k + axis]));
                let texel = place[axis] - corner[axis] as f64;
                assert!((rest - (texel - 0.5 * size as f64)).abs() < 1e-4);
                assert!((uv - texel / size as f64).abs() < 1e-6);
            }
        }
        assert_eq!(mesh.indices.len(), 6 * set.element_len(), "quads in two");
        let texture = &puppet.textures[part.textures[0] as usize];
        let size = [texture.width, texture.height].map(|side| side as usize);
        assert_eq!(size, [picture.size.width, picture.size.height]);
    }
    // The foremost part at each node belongs to the characteristic view, and all of it is visible.
    for (i, j, shown) in &nodes {
        let value = |node: &Node, name: &ParamName| -> f32 {
            let binding = binding(&puppet, node.uuid, name);
            assert_eq!(binding.interpolate_mode, Interpolation::Nearest);
            number(&binding, *i, *j)
        };
        let behind = |node: &Node| value(node, &ParamName::Other("zSort".to_owned()));
        let front = parts.iter().min_by(|a, b| behind(a).total_cmp(&behind(b))).unwrap();
        assert_eq!((Some(key(front)), behind(front)), (shown.view(), 0.0));
        for node in &parts {
            let seen = f32::from(u8::from(node.uuid == front.uuid));
            assert_eq!(value(node, &ParamName::Opacity), seen);
        }
    }
}

#[test]
fn a_head_goes_all_the_way_round_in_a_puppet_of_one_parameter() {
    let folder = Folder::new("round");
    let (_, trained, file) = made(&folder, "head");
    let sides = [side("yaw", None, 25)];
    let grid = Grid::of_sides(&file, None, &Values::new(), &sides).unwrap();
    let puppet = Puppet::from_bytes(&puppet(&file, None, &grid).unwrap()).unwrap();
    let parameter = puppet.params.values().next().unwrap();
    assert!(!parameter.is_vec2 && parameter.max[0] == 360.0);
    assert_eq!(parameter.axis_points.each_ref().map(Vec::len), [25, 1]);
    let nodes: Vec<_> =
        (0..25).map(|i| (i, 0, shown(&trained, &[("yaw", 15.0 * i as f64)]))).collect();
    let parts = || puppet.nodes.iter().filter(|node| node.type_node.as_part().is_some());
    assert_eq!(parts().count(), 12);
    for node in parts() {
        let part = node.type_node.as_part().unwrap();
        is_bent((node, part), &puppet, &trained.model, &nodes, [80.0, 96.0]);
    }
    // The renderer of the tests has no antialiasing, and the outline is most of the difference.
    is_drawn("head", &file, &grid, &puppet, 28.0);
}

#[test]
fn a_figure_of_one_picture_is_drawn_as_the_model_draws_it() {
    let folder = Folder::new("figure-puppet");
    let (_, _, file) = made(&folder, "figure");
    let grid = Grid::of_sides(&file, None, &Values::new(), &[side("phase", None, 9)]).unwrap();
    let puppet = Puppet::from_bytes(&puppet(&file, None, &grid).unwrap()).unwrap();
    is_drawn("figure", &file, &grid, &puppet, 40.0);
}

/// Draws a puppet with one parameter at its nodes, and compares it with the model's pictures, dB.
fn is_drawn(name: &str, file: &Model<Vec<u8>>, grid: &Grid, puppet: &Puppet, bar: f64) {
    let screen = Player::new(file, None).unwrap().size();
    let off = |(node, shown): (usize, &GridNode)| {
        let pose = posed(puppet, screen, [node as f64, 0.0]);
        psnr(&draw(screen, &pose.sheets, &pose.order), &drawn(file, &shown.values))
    };
    let all: Vec<f64> = grid.nodes.iter().enumerate().map(off).collect();
    let worst = all.iter().copied().fold(f64::INFINITY, f64::min);
    println!("puppet of the {name} over the model: worst {worst:.2} dB of {all:.1?}");
    assert!(worst > bar, "{name}: {all:?}");
}

#[test]
fn invalid_grids_are_refused() {
    let folder = Folder::new("no-grid");
    let (_, _, file) = made(&folder, "panel");
    let of = |sides: &[Side]| {
        let bend: Values = [("bend".to_owned(), 0.0), ("pitch".to_owned(), 0.0)].into();
        Grid::of_sides(&file, None, &bend, sides).unwrap_err()
    };
    let unknown = of(&[side("nod", None, 3)]).to_string();
    assert_eq!(unknown, "\"nod\" is no parameter: expected pitch, yaw, bend");
    let twice = [side("yaw", None, 3), side("yaw", None, 3)];
    assert_eq!(of(&twice).message(), "parameter \"yaw\" is given twice");
    let error = of(&[side("bend", None, 3)]);
    assert_eq!(error.message(), "parameter \"bend\" is given twice");
    for side in [side("yaw", None, 1), side("yaw", Some([3.0, 3.0]), 2)] {
        let error = of(&[side]);
        assert_eq!(error.kind(), ErrorKind::Value);
        assert!(error.message().contains("\"yaw\": expected 2 nodes or more"), "{error}");
    }
    let bare = Grid::of_sides(&file, None, &Values::new(), &[side("yaw", None, 2)]);
    assert_eq!(bare.unwrap_err().to_string(), "parameter \"pitch\" is missing");
}
