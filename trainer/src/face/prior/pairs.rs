//! Which shapes belong together: those of the two sides.

use crate::face::names::{Expression, Side};

/// Pairs of shapes, left and right.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Pairs {
    /// Those that each move their side: a smile.
    pub mirrored: Vec<[usize; 2]>,
    /// Those that pull one thing to their side, of which one alone is at work: the jaw.
    pub cancelling: Vec<[usize; 2]>,
}

/// The cosine between the deltas of a pair below which one undoes the other. Of ICT FaceKit's pairs the jaw has -0.98
/// and the mouth -0.78, all others are above -0.01.
const OPPOSED: f64 = -0.5;

/// Finds pairs by their names, and tells apart by their deltas what they do.
///
/// - `names`: of S shapes.
/// - `deltas`: S x V.
pub fn pairs(names: &[String], deltas: &[Vec<[f64; 3]>]) -> Pairs {
    let all: Vec<Expression> = names.iter().map(|name| Expression::of(name)).collect();
    let mut found = Pairs::default();
    for (left, expression) in all.iter().enumerate() {
        if expression.side != Some(Side::Left) {
            continue;
        }
        let other = Expression { stem: expression.stem.clone(), side: Some(Side::Right) };
        let Some(right) = all.iter().position(|expression| *expression == other) else { continue };
        let [Some(a), Some(b)] = [left, right].map(|shape| deltas.get(shape)) else { continue };
        let (a, b) = (a.as_flattened(), b.as_flattened());
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let is_opposed = dot(a, b) < OPPOSED * (dot(a, a) * dot(b, b)).sqrt();
        let which = if is_opposed { &mut found.cancelling } else { &mut found.mirrored };
        which.push([left, right]);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_undoes_the_other_cancels_and_the_rest_mirrors() {
        let names = ["smile_R", "jawLeft", "smile_L", "jawOpen", "jawRight", "blinkLeft"];
        let names = names.map(str::to_owned);
        let deltas: Vec<Vec<[f64; 3]>> = [
            [[-1.0, 1.0, 0.0], [0.0; 3]],
            [[1.0, 0.0, 0.0], [1.0, 0.0, 0.1]],
            [[0.0; 3], [1.0, 1.0, 0.0]],
            [[0.0, -1.0, 0.0], [0.0, -1.0, 0.0]],
            [[-1.0, 0.0, 0.1], [-1.0, 0.0, 0.0]],
            [[1.0, 0.0, 0.0], [0.0; 3]],
        ]
        .map(Vec::from)
        .into();
        let found = pairs(&names, &deltas);
        assert_eq!(found, Pairs { mirrored: vec![[2, 0]], cancelling: vec![[1, 4]] });
    }
}
