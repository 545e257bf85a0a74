//! Pictures that are laid one over the other so that each counts by its share.
//!
//! Tools of 2-D rigs blend a picture over those below it. Two halves at an opacity of 0.5 leave a quarter of the ground to
//! be seen. So the undermost picture stays opaque, and those above it fade.

/// Opacity that is left to lower pictures below which none of them is seen.
const HIDDEN: f64 = 1e-6;

/// Lists the key views that count at a node, the undermost first: that of the greatest share in all nodes.
///
/// - `shares`: by node, of N views.
pub(super) fn order(shares: &[Vec<f64>]) -> Vec<usize> {
    let len = shares.first().map_or(0, Vec::len);
    let whole = |view: usize| shares.iter().map(|own| own[view]).sum::<f64>();
    let mut out: Vec<usize> = (0..len).filter(|&view| whole(view) > 0.0).collect();
    out.sort_by(|&a, &b| whole(b).total_cmp(&whole(a)));
    out
}

/// Returns the opacities of pictures at a node. Opaque pictures then mix by their shares.
///
/// A picture that is wholly covered is opaque if it counts beside the node. Tools go from node to node along lines, and the
/// background stays hidden on the way.
///
/// - `order`: views, the undermost first.
/// - `shares`: of N views, 1 in sum or less.
/// - `opacity`: of all of them together.
/// - `counts_beside`: whether a view counts at a node beside this one.
pub(super) fn opacities(
    order: &[usize],
    shares: &[f64],
    opacity: f64,
    counts_beside: impl Fn(usize) -> bool,
) -> Vec<f64> {
    let mut left = 1.0;
    let mut out: Vec<f64> = Vec::new();
    for &view in order.iter().rev() {
        let own = opacity * shares[view];
        out.push(match left > HIDDEN {
            true => (own / left).clamp(0.0, 1.0),
            false => f64::from(u8::from(counts_beside(view))),
        });
        left -= own;
    }
    out.reverse();
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How much of each picture is seen, and of the ground, where all are opaque.
    fn seen(opacities: &[f64]) -> Vec<f64> {
        let mut left = 1.0;
        let mut out: Vec<f64> = Vec::new();
        for opacity in opacities.iter().rev() {
            out.push(left * opacity);
            left *= 1.0 - opacity;
        }
        out.reverse();
        out.push(left);
        out
    }

    #[test]
    fn opaque_pictures_mix_by_their_shares() {
        for opacity in [1.0, 0.5, 0.0] {
            for shares in [[0.5, 0.5, 0.0], [0.2, 0.3, 0.5], [0.0, 0.0, 1.0], [0.1, 0.0, 0.2]] {
                let found = seen(&opacities(&[2, 0, 1], &shares, opacity, |_| true));
                let expected = [2, 0, 1].map(|view| opacity * shares[view]);
                let apart = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
                assert!(apart.fold(0.0, f64::max) < 1e-12, "{shares:?} {opacity}: {found:?}");
            }
        }
    }

    #[test]
    fn nothing_is_seen_through_halfway_between_nodes() {
        // Along a line of three nodes the first view goes over into the second, and that into the third.
        let nodes = [vec![1.0, 0.0, 0.0], vec![0.0, 1.0, 0.0], vec![0.0, 0.0, 1.0]];
        let order = order(&nodes);
        let at = |node: usize| {
            let beside = |view: usize| {
                let nodes = &nodes[node.saturating_sub(1)..nodes.len().min(node + 2)];
                nodes.iter().any(|shares| shares[view] > 0.0)
            };
            opacities(&order, &nodes[node], 1.0, beside)
        };
        for pair in [[0, 1], [1, 2]] {
            let [from, to] = pair.map(at);
            for share in [0.0, 0.3, 0.5, 1.0] {
                let own: Vec<f64> =
                    from.iter().zip(&to).map(|(a, b)| a + share * (b - a)).collect();
                assert_eq!(seen(&own).last(), Some(&0.0), "{pair:?} {share}: {own:?}");
            }
        }
    }

    #[test]
    fn the_view_that_counts_most_is_undermost_and_one_that_never_counts_is_left_out() {
        assert_eq!(order(&[vec![0.1, 0.0, 0.9], vec![0.3, 0.0, 0.7]]), [2, 0]);
        assert_eq!(order(&[]), [0; 0]);
    }
}
