//! Evaluates a model at the nodes of a grid of parameters, at its key views, or along a path.

use crate::Error;
use crate::scattered::model::{Input, InputKind, features};
use crate::views::fit::{given, names_of, unknown_parameter, with_features};
use crate::views::inverse::starts;
use crate::views::object::ObjectMap;
use crate::views::player::{Played, Player};
use crate::views::set::Values;
use serde_json::Value;
use sinew_runtime::Model;

/// A requested side of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Side {
    /// Name of the parameter.
    pub name: String,
    /// Range of the side; if `None`, the range of the training views.
    pub range: Option<[f64; 2]>,
    /// Number of nodes.
    pub nodes: usize,
}

/// A model evaluated at the nodes of a grid.
#[derive(Clone, Debug)]
pub struct Grid {
    /// Sides with their ranges; empty if the nodes are key views or frames.
    pub sides: Vec<(Side, [f64; 2])>,
    /// Nodes. The index of the first side changes slowest.
    pub nodes: Vec<Node>,
}

/// A node of a grid.
#[derive(Clone, Debug)]
pub struct Node {
    /// Name of the node.
    pub name: String,
    /// Values of the parameters.
    pub values: Values,
    /// Outputs of the map.
    pub played: Played,
}

/// Tolerance around the range of a rotation's feature, over the range.
const TOLERANCE: f64 = 0.02;
/// Largest RMS error of a key view that belongs to a map, pixels.
const MATCH: f64 = 0.5;
/// Degrees of a full turn.
const ROUND: usize = 360;

impl Grid {
    /// Evaluates a map at the nodes of a grid.
    ///
    /// - `values`: all parameters without a side.
    ///
    /// # Errors
    /// The file has no such map; a side has no parameter, no range, fewer than two nodes or an empty range; a parameter
    /// is given twice or is missing; or the model cannot be evaluated.
    pub fn of_sides(
        model: &Model<Vec<u8>>,
        map: Option<&str>,
        values: &Values,
        sides: &[Side],
    ) -> Result<Self, Error> {
        let player = Player::new(model, map)?;
        let names = names_of(player.inputs());
        for (number, Side { name, .. }) in sides.iter().enumerate() {
            if !names.contains(&name.as_str()) {
                return Err(unknown_parameter(name, &names));
            }
            let earlier = sides[..number].iter().any(|other| other.name == *name);
            if earlier || values.contains_key(name) {
                return Err(Error::value(format!("parameter \"{name}\" is given twice")));
            }
        }
        let mut ranged = Vec::new();
        for side in sides {
            let range = match side.range {
                Some(range) => range,
                None => training_range(&player, values, &side.name)?,
            };
            if side.nodes < 2 || range[0].total_cmp(&range[1]).is_ge() {
                let name = &side.name;
                return Err(Error::value(format!(
                    "parameter \"{name}\": expected 2 nodes or more, and a range that is not empty"
                )));
            }
            ranged.push((side.clone(), range));
        }
        let mut all = vec![(Vec::new(), values.clone())];
        for (side, [low, high]) in &ranged {
            let at = |node: usize| low + (high - low) * node as f64 / (side.nodes - 1) as f64;
            let nodes = all.iter().flat_map(|earlier| (0..side.nodes).map(move |k| (earlier, k)));
            let with = |((named, values), node): (&(Vec<String>, Values), usize)| {
                let (mut named, mut values) = (named.clone(), values.clone());
                named.push(format!("{} {}", side.name, at(node)));
                values.insert(side.name.clone(), at(node));
                (named, values)
            };
            all = nodes.map(with).collect();
        }
        let node =
            |(named, values): (Vec<String>, Values)| shown(&player, named.join(", "), values);
        Ok(Self { sides: ranged, nodes: all.into_iter().map(node).collect::<Result<_, _>>()? })
    }

    /// Evaluates a map at the frames of a path.
    ///
    /// # Errors
    /// The file has no such map, or a frame cannot be evaluated.
    pub fn of_frames(
        model: &Model<Vec<u8>>,
        map: Option<&str>,
        frames: &[Values],
    ) -> Result<Self, Error> {
        let player = Player::new(model, map)?;
        let node = |(number, values): (usize, &Values)| {
            shown(&player, format!("frame {number}"), values.clone())
        };
        let nodes = frames.iter().enumerate().map(node).collect::<Result<_, _>>()?;
        Ok(Self { sides: Vec::new(), nodes })
    }

    /// Evaluates a map at its key views. Their parameters are found from their points.
    ///
    /// # Errors
    /// The file has no such map, no key view belongs to the map, or the map cannot be evaluated.
    pub fn of_key_views(model: &Model<Vec<u8>>, map: Option<&str>) -> Result<Self, Error> {
        let player = Player::new(model, map)?;
        let views = player.views();
        let object = ObjectMap::new(&player);
        let starts = starts(&object.model);
        let mut nodes = Vec::new();
        for view in 0..views.view_len() {
            let place = |point: usize| {
                let seen = views.is_visible(view, point).filter(|is_seen| *is_seen);
                seen.and_then(|_| Some(views.reference(view, point)?.map(f64::from)))
            };
            let points: Vec<_> = (0..views.point_len()).map(place).collect();
            let found = object.find(&points, &starts)?;
            if found.rms < MATCH {
                let name = views.view_name(view).unwrap_or_default().to_owned();
                nodes.push(shown(&player, name, found.values)?);
            }
        }
        if nodes.is_empty() {
            return Err(Error::missing("no key view is of this map: say a grid"));
        }
        Ok(Self { sides: Vec::new(), nodes })
    }

    /// Lists the nodes of all cells that a node is a corner of. Nodes without sides form a line.
    pub(super) fn beside(&self, node: usize) -> Vec<usize> {
        let rows = self.sides.get(1).map_or(1, |(side, _)| side.nodes);
        let around = |at: usize, len: usize| at.saturating_sub(1)..(at + 2).min(len);
        let columns = around(node / rows, self.nodes.len() / rows);
        let of_column =
            |column: usize| around(node % rows, rows).map(move |row| column * rows + row);
        columns.flat_map(of_column).collect()
    }
}

/// Evaluates one node.
fn shown(player: &Player<'_>, name: String, values: Values) -> Result<Node, Error> {
    Ok(Node { name, played: player.play(&values)?, values })
}

/// Finds the range of a parameter in training. A number has a range. For an angle the range is the longest run of whole
/// degrees whose rotation lies in the range of the training rotations. Other angles without a value are 0.
fn training_range(player: &Player<'_>, values: &Values, name: &str) -> Result<[f64; 2], Error> {
    let no_range = || {
        Error::missing(format!(
            "how far does \"{name}\" go? Say from where to where: {name}=-30..30"
        ))
    };
    let range = |feature: usize| {
        let [.., low, high] = player.map().feature(feature).unwrap_or_default().map(f64::from);
        [low, high]
    };
    let is_own = |own: &(&Input, usize)| names_of(std::slice::from_ref(own.0)).contains(&name);
    let found = with_features(player.inputs()).find(is_own);
    let (input, first) = found.ok_or_else(no_range)?;
    if input.kind == InputKind::Scalar {
        return Ok(range(first));
    }
    let inputs = std::slice::from_ref(input);
    let is_inside = |degrees: usize| -> Result<bool, Error> {
        let angle = |other: &str| match values.get(other) {
            _ if other == name => degrees as f64,
            value => value.copied().unwrap_or_default(),
        };
        let own = names_of(inputs).into_iter().map(|other| (other.to_owned(), angle(other)));
        let own: Values = own.collect();
        let own = features(inputs, &given(inputs, &own)?)?;
        Ok(own.iter().zip(first..).all(|(x, feature)| {
            let [low, high] = range(feature);
            let beyond = TOLERANCE * (high - low) + 1e-6;
            (low - beyond..=high + beyond).contains(x)
        }))
    };
    let among: Vec<bool> = (0..ROUND).map(is_inside).collect::<Result<_, _>>()?;
    longest_run(&among).ok_or_else(no_range)
}

/// Makes the error of nodes at which nothing is drawn.
pub(super) fn nothing_drawn() -> Error {
    Error::missing("nothing is drawn at any node")
}

/// Writes JSON.
///
/// # Errors
/// A number cannot be written.
pub(super) fn json_bytes(value: &Value) -> Result<Vec<u8>, Error> {
    serde_json::to_vec(value)
        .map_err(|error| Error::value(format!("cannot be put together: {error}")).caused_by(error))
}

/// Returns the ends of the longest run of degrees, which wraps around, between -180 and 360. `None` without a run of
/// two degrees.
fn longest_run(among: &[bool]) -> Option<[f64; 2]> {
    if among.iter().all(|is_inside| *is_inside) {
        return Some([0.0, ROUND as f64]);
    }
    let len = |from: &usize| (0..ROUND).take_while(|step| among[(from + step) % ROUND]).count();
    let (from, len) = (0..ROUND).map(|from| (from, len(&from))).max_by_key(|(_, len)| *len)?;
    let back = if from >= ROUND / 2 { ROUND as f64 } else { 0.0 };
    let from = from as f64 - back;
    (len > 1).then(|| [from, from + (len - 1) as f64])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_of_a_cell_are_neighbours() {
        let played = Played {
            points: Vec::new(),
            visibility: Vec::new(),
            scores: Vec::new(),
            layers: Vec::new(),
            view: 0,
            confidence: 1.0,
        };
        let node = Node { name: String::new(), values: Values::new(), played };
        let side = |nodes| (Side { name: String::new(), range: None, nodes }, [0.0, 1.0]);
        let grid = |sides, len| Grid { sides, nodes: vec![node.clone(); len] };
        let line = grid(Vec::new(), 5);
        assert_eq!((line.beside(0), line.beside(3)), (vec![0, 1], vec![2, 3, 4]));
        let square = grid(vec![side(3), side(4)], 12);
        assert_eq!(square.beside(0), [0, 1, 4, 5]);
        assert_eq!(square.beside(6), [1, 2, 3, 5, 6, 7, 9, 10, 11]);
        assert_eq!(square.beside(11), [6, 7, 10, 11]);
    }

    #[test]
    fn the_longest_run_of_degrees_comes_round() {
        let of = |inside: &dyn Fn(usize) -> bool| {
            longest_run(&(0..ROUND).map(inside).collect::<Vec<_>>())
        };
        assert_eq!(of(&|at| at <= 40 || at >= 325), Some([-35.0, 40.0]));
        assert_eq!(of(&|at| (90..=270).contains(&at) || at == 3), Some([90.0, 270.0]));
        assert_eq!(of(&|_| true), Some([0.0, 360.0]));
        assert_eq!(of(&|at| at == 7), None);
    }
}
