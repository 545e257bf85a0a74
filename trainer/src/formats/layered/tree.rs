//! The tree of layers and groups, its list of layers, and the errors that both formats share.

use crate::Error;
use std::fmt::Display;

/// Largest depth of nested groups.
pub(super) const DEPTH: usize = 64;
/// Most layers of a file.
const LAYERS: usize = 8192;
/// Most bytes of a layer's path.
const PATH: usize = 4096;

/// A layer or a group.
pub(super) struct Node {
    pub(super) name: String,
    /// Index in the file.
    pub(super) source: usize,
    /// Opacity, in [0, 1].
    pub(super) opacity: f64,
    /// Blend mode, as the file writes it; `None` for normal.
    pub(super) blend: Option<String>,
    pub(super) is_hidden: bool,
    /// Whether the layer shows only within the layer below.
    pub(super) is_clipped: bool,
    /// Members of a group, the hindmost first; `None` for a layer.
    pub(super) members: Option<Vec<Node>>,
}

/// A layer of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PaintedLayer {
    /// Path: the names of the groups and of the layer, as `head/eye`.
    pub(crate) path: String,
    /// Name of the layer.
    pub(crate) name: String,
    /// Opacity in [0, 1], times the opacities of the groups; 0 if the layer or a group is hidden. A clipped layer
    /// leaves out the groups that also contain its base layer.
    pub(crate) opacity: f64,
    /// Index of the base layer that this layer is clipped to. The layer's coverage is multiplied with the coverage and
    /// opacity of the base.
    pub(crate) clip: Option<usize>,
    /// Blend mode of the layer or of a group; `None` for normal.
    pub(super) blend: Option<String>,
    /// Index in the file.
    pub(super) source: usize,
    /// Indices of the groups in the file.
    pub(super) groups: Vec<usize>,
}

/// Lists the layers of a tree, the hindmost first, and the paths of its groups.
///
/// # Errors
/// There is no layer or there are too many, two layers have the same path, a path is too long, or a layer is clipped to
/// a group or to nothing.
pub(super) fn list_layers(nodes: Vec<Node>) -> Result<(Vec<PaintedLayer>, Vec<String>), Error> {
    let mut out = Lists::default();
    out.add(nodes, &PaintedLayer { opacity: 1.0, ..PaintedLayer::default() })?;
    let mut paths: Vec<&str> = out.layers.iter().map(|layer| layer.path.as_str()).collect();
    paths.sort_unstable();
    match paths.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(twice) => {
            Err(Error::value(format!("has two layers \"{}\": give each its own name", twice[0])))
        }
        None if out.layers.is_empty() => {
            Err(Error::missing("has no layers: save it with layers, or save a PNG"))
        }
        None => Ok((out.layers, out.groups)),
    }
}

impl PaintedLayer {
    /// Whether the layer is drawn: neither the layer nor its base is hidden.
    ///
    /// - `all`: all layers of the file.
    pub(crate) fn is_shown(&self, all: &[Self]) -> bool {
        self.opacity > 0.0 && self.clip.is_none_or(|base| all[base].is_shown(all))
    }
}

#[derive(Default)]
struct Lists {
    layers: Vec<PaintedLayer>,
    groups: Vec<String>,
}

impl Lists {
    /// Adds the members of a group; they inherit the properties of the group.
    fn add(&mut self, nodes: Vec<Node>, group: &PaintedLayer) -> Result<(), Error> {
        // The layer to which the following layers are clipped, or else what lies there, in words.
        let mut base = Err("nothing".to_owned());
        for node in nodes {
            let path = match group.path.is_empty() {
                true => node.name.clone(),
                false => format!("{}/{}", group.path, node.name),
            };
            if path.len() > PATH {
                let what =
                    format!("the name of a layer, expected at most {PATH} bytes with its groups");
                return Err(too_large(what));
            }
            if self.layers.len() == LAYERS {
                return Err(too_large(format!("expected at most {LAYERS} layers")));
            }
            let clip = match (node.is_clipped, &base) {
                (false, _) => group.clip,
                (true, Ok(layer)) => Some(*layer),
                (true, Err(other)) => return Err(wrongly_clipped(&path, other)),
            };
            let opacity = if node.is_hidden { 0.0 } else { node.opacity };
            let own = PaintedLayer {
                name: node.name,
                // The base of a clipped layer already has the group's opacity.
                opacity: if node.is_clipped { opacity } else { group.opacity * opacity },
                clip,
                blend: node.blend.or_else(|| group.blend.clone()),
                source: node.source,
                groups: group.groups.clone(),
                path,
            };
            let next = match node.members {
                None => {
                    self.layers.push(own);
                    Ok(self.layers.len() - 1)
                }
                Some(members) => {
                    self.groups.push(own.path.clone());
                    let groups = [&own.groups[..], &[own.source]].concat();
                    let other = format!("group \"{}\"", own.path);
                    self.add(members, &PaintedLayer { groups, ..own })?;
                    Err(other)
                }
            };
            if !node.is_clipped {
                base = next;
            }
        }
        Ok(())
    }
}

/// Makes the error of a file that breaks its format.
pub(super) fn damaged(what: impl Display) -> Error {
    Error::damaged(format!("is damaged: {what}"))
}

/// Makes the error of a file beyond the limits.
pub(super) fn too_large(what: impl Display) -> Error {
    Error::limit(format!("is too large: {what}"))
}

/// Makes the error of a clipped layer whose base cannot be represented; `base` is what lies below it, in words.
pub(super) fn wrongly_clipped(layer: &str, base: impl Display) -> Error {
    Error::unsupported(format!(
        "layer \"{layer}\" is clipped to {base}, expected one layer below it in its group"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(name: &str, is_clipped: bool, members: Option<Vec<Node>>) -> Node {
        Node {
            name: name.to_owned(),
            source: 0,
            opacity: 0.5,
            blend: None,
            is_hidden: name == "hidden",
            is_clipped,
            members,
        }
    }

    #[test]
    fn layers_inherit_from_their_groups() {
        let inner = vec![
            node("a", false, None),
            node("b", true, None),
            node("c", true, None),
            node("hidden", false, None),
        ];
        let nodes = vec![
            node("back", false, None),
            node("group", true, Some(inner)),
            node("front", true, None),
        ];
        let (layers, groups) = list_layers(nodes).unwrap();
        let found: Vec<_> =
            layers.iter().map(|own| (own.path.as_str(), own.opacity, own.clip)).collect();
        let expected = [
            ("back", 0.5, None),
            ("group/a", 0.25, Some(0)),
            ("group/b", 0.5, Some(1)),
            ("group/c", 0.5, Some(1)),
            ("group/hidden", 0.0, Some(0)),
            ("front", 0.5, Some(0)),
        ];
        assert_eq!(found, expected);
        assert_eq!(groups, ["group"]);
    }

    #[test]
    fn clipped_layers_without_a_layer_below_and_equal_names_are_refused() {
        let said = |nodes| list_layers(nodes).unwrap_err().to_string();
        let group = || node("g", false, Some(vec![node("a", false, None)]));
        assert!(said(vec![node("x", true, None)]).starts_with("layer \"x\" is clipped to nothing"));
        assert_eq!(
            said(vec![group(), node("x", true, None)]),
            "layer \"x\" is clipped to group \"g\", expected one layer below it in its group"
        );
        assert_eq!(said(vec![]), "has no layers: save it with layers, or save a PNG");
        assert_eq!(said(vec![group(), group()]), "has two layers \"g/a\": give each its own name");
    }
    #[test]
    fn files_of_more_layers_or_longer_names_than_any_program_writes_are_refused() {
        let said = |nodes| list_layers(nodes).unwrap_err().to_string();
        let many = (0..=LAYERS).map(|at| node(&at.to_string(), false, None));
        assert_eq!(said(many.collect()), "is too large: expected at most 8192 layers");
        let long = "x".repeat(2048);
        let inner = vec![node(&long, false, None)];
        assert_eq!(
            said(vec![node(&long, false, Some(inner))]),
            "is too large: the name of a layer, expected at most 4096 bytes with its groups"
        );
    }
}
