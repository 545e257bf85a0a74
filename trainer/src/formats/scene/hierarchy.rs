//! Nodes of a scene: their names, and the tree that they form.

use crate::formats::FormatWarning;
use nalgebra::Matrix4;
use std::collections::{BTreeMap, HashSet};

/// The nodes of a scene.
pub(in crate::formats) struct Hierarchy {
    /// Names of the nodes.
    pub(in crate::formats) names: Vec<String>,
    /// Parent of each node.
    pub(in crate::formats) parents: Vec<Option<usize>>,
}

impl Hierarchy {
    /// Walks from a node up to its root.
    pub(in crate::formats) fn upwards(&self, node: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(node), |&node| self.parents[node])
    }

    /// Returns, for each of some nodes, the nearest of these nodes above it; several may have none.
    pub(in crate::formats) fn parents_among(&self, nodes: &[usize]) -> Vec<Option<usize>> {
        let of = |above: usize| nodes.iter().position(|&node| node == above);
        nodes.iter().map(|&node| self.upwards(node).skip(1).find_map(of)).collect()
    }

    /// Lists the nodes that may be joints, with unique names: all that show no mesh, joints first.
    pub(in crate::formats) fn candidates(
        &self,
        is_joint: impl Fn(usize) -> bool,
        shows: impl Fn(usize) -> bool,
    ) -> Vec<(usize, String)> {
        let labels = self.unique_names(&is_joint).0.into_iter().enumerate();
        let mut all: Vec<_> = labels.filter(|(node, _)| !shows(*node)).collect();
        all.sort_by_key(|(node, _)| !is_joint(*node));
        all
    }

    /// Returns the bind frame of a joint. A joint without a skin moves rigidly with its nearest skinned ancestor, or
    /// else with any skinned joint, from the pose without animation.
    ///
    /// - `binds`, `at_rest`: world frames of all nodes, as skins bind them and without animation.
    pub(in crate::formats) fn bound(
        &self,
        joint: usize,
        binds: &[Option<Matrix4<f64>>],
        at_rest: &[Matrix4<f64>],
    ) -> Option<Matrix4<f64>> {
        let any = binds.iter().position(Option::is_some);
        let known = self.upwards(joint).find(|&node| binds[node].is_some()).or(any)?;
        if known == joint {
            return binds[joint];
        }
        Some(binds[known]? * at_rest[known].try_inverse()? * at_rest[joint])
    }

    /// Makes the names of joints unique. The nearest ancestors with different names qualify equal names: `left arm/hand`
    /// and `right arm/hand`. Without such ancestors the second joint becomes `hand 2`.
    ///
    /// - `is_joint`: whether a node is a joint; other nodes keep their names.
    ///
    /// Returns the names of all nodes, and a warning if joints were renamed.
    pub(in crate::formats) fn unique_names(
        &self,
        is_joint: impl Fn(usize) -> bool,
    ) -> (Vec<String>, Option<FormatWarning>) {
        let names = &self.names;
        let above = |node: usize| self.upwards(node).skip(1);
        let mut groups: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for node in (0..names.len()).filter(|&node| is_joint(node)) {
            groups.entry(&names[node]).or_default().push(node);
        }
        let mut groups: Vec<Vec<usize>> =
            groups.into_values().filter(|group| group.len() > 1).collect();
        // Ancestors first, because their new names qualify their descendants.
        groups.sort_by_key(|group| group.iter().map(|&node| above(node).count()).min());
        let mut labels = names.to_vec();
        // Qualifiers have numbers, but no qualifiers of their own.
        let mut qualifiers = names.to_vec();
        let mut taken: HashSet<String> = names.iter().cloned().collect();
        for group in &groups {
            let name = &names[group[0]];
            let deepest = group.iter().map(|&node| above(node).count()).max().unwrap_or(0);
            let qualified = |level: usize| -> Vec<String> {
                let label = |&node: &usize| match above(node).nth(level) {
                    Some(above) => format!("{}/{name}", qualifiers[above]),
                    None => name.clone(),
                };
                group.iter().map(label).collect()
            };
            let differ = |all: &Vec<String>| {
                let distinct: HashSet<&String> = all.iter().collect();
                let is_free = |label: &String| label == name || !taken.contains(label);
                distinct.len() == all.len() && all.iter().all(is_free)
            };
            let by_place = (0..deepest).map(qualified).find(differ);
            let is_numbered = by_place.is_none();
            let own = by_place.unwrap_or_else(|| {
                let numbers = (2..).map(|number: usize| format!("{name} {number}"));
                let free = numbers.filter(|label| !taken.contains(label));
                std::iter::once(name.clone()).chain(free).take(group.len()).collect()
            });
            for (&node, label) in group.iter().zip(own) {
                taken.insert(label.clone());
                if is_numbered {
                    qualifiers[node].clone_from(&label);
                }
                labels[node] = label;
            }
        }
        let renamed = (0..names.len()).filter(|&node| labels[node] != names[node]);
        let renamed = renamed.map(|node| labels[node].clone()).collect();
        (labels, FormatWarning::listed(FormatWarning::EqualNames, renamed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_names_get_a_qualifier_or_a_number() {
        let tree = |names: &[&str], parents: &[Option<usize>]| Hierarchy {
            names: names.iter().map(|&name| name.to_owned()).collect(),
            parents: parents.to_vec(),
        };
        let nodes = tree(
            &["rig", "left", "hand", "right", "hand", "thumb", "thumb"],
            &[None, Some(0), Some(1), Some(0), Some(3), Some(2), Some(4)],
        );
        let (labels, renamed) = nodes.unique_names(|_| true);
        let expected = ["left/hand", "right/hand", "left/thumb", "right/thumb"];
        assert_eq!([2, 4, 5, 6].map(|node| labels[node].as_str()), expected);
        let expected = expected.map(str::to_owned).to_vec();
        assert_eq!(renamed, Some(FormatWarning::EqualNames(expected)));

        // Two copies under one node.
        let nodes = tree(
            &["rig", "root", "mid", "tip", "root", "mid", "tip", "root 2"],
            &[None, Some(0), Some(1), Some(2), Some(0), Some(4), Some(5), Some(0)],
        );
        let (labels, _) = nodes.unique_names(|_| true);
        assert_eq!(
            labels[1..],
            ["root", "root/mid", "root/tip", "root 3", "root 3/mid", "root 3/tip", "root 2"]
        );
        // A mesh with the name of a joint is not a joint.
        assert_eq!(nodes.unique_names(|node| node < 4), (nodes.names.clone(), None));
    }
}
