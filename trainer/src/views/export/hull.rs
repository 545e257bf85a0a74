//! The border of a mesh.

use std::collections::HashMap;

/// Lists the vertices along the longest border of triangles, each once; none of a mesh without a border.
pub(super) fn hull(triangles: &[[usize; 3]]) -> Vec<usize> {
    let edges = |[a, b, c]: [usize; 3]| [[a, b], [b, c], [c, a]];
    let mut counts: HashMap<[usize; 2], usize> = HashMap::new();
    for [a, b] in triangles.iter().copied().flat_map(edges) {
        *counts.entry([a.min(b), a.max(b)]).or_default() += 1;
    }
    let mut border: Vec<[usize; 2]> =
        counts.into_iter().filter(|(_, count)| *count == 1).map(|(edge, _)| edge).collect();
    // Maps come in no order.
    border.sort_unstable();
    let mut longest = Vec::new();
    while let Some([start, next]) = border.pop() {
        let mut way = vec![start];
        let mut at = next;
        while at != start {
            way.push(at);
            let Some(found) = border.iter().position(|edge| edge.contains(&at)) else { break };
            let [a, b] = border.swap_remove(found);
            at = if a == at { b } else { a };
            // Two borders may meet at a vertex: the loop between is a border by itself.
            if let Some(first) = way.iter().position(|&vertex| vertex == at).filter(|&at| at > 0) {
                let own = way.split_off(first);
                longest = longer(longest, own);
            }
        }
        longest = longer(longest, way);
    }
    longest
}

fn longer(a: Vec<usize>, b: Vec<usize>) -> Vec<usize> {
    if b.len() > a.len() { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Turns a loop so that its least vertex comes first, and the lesser of its neighbours second.
    fn turned(way: Vec<usize>) -> Vec<usize> {
        let mut way = way;
        let least = (0..way.len()).min_by_key(|&at| way[at]).unwrap_or(0);
        way.rotate_left(least);
        if way.len() > 2 && way[way.len() - 1] < way[1] {
            way[1..].reverse();
        }
        way
    }

    #[test]
    fn the_border_goes_round_once() {
        assert_eq!(turned(hull(&[[0, 1, 2], [0, 2, 3]])), [0, 1, 2, 3]);
        // Turned over, and a vertex in the middle.
        let fan = [[0, 1, 4], [4, 1, 2], [2, 3, 4], [4, 0, 3]];
        assert_eq!(turned(hull(&fan)), [0, 1, 2, 3]);
        assert_eq!(hull(&[]), [0; 0]);
    }

    #[test]
    fn of_two_pieces_the_longer_border_counts_also_where_they_touch() {
        let apart = [[0, 1, 2], [3, 4, 5], [3, 5, 6]];
        assert_eq!(turned(hull(&apart)), [3, 4, 5, 6]);
        let touching = [[0, 1, 2], [2, 3, 4], [2, 4, 5]];
        assert_eq!(turned(hull(&touching)), [2, 3, 4, 5]);
    }
}
