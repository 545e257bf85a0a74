//! The polynomials that are tried: products of features.

use crate::scattered::model::{Input, InputKind};
use crate::scattered::sum::Term;

/// Features of a rotation's first two rows: all that an orthographic view of a rigid object is made of.
const TWO_ROWS: usize = 6;

/// A product of features, ascending; none is 1.
pub(super) type Monomial = Vec<usize>;

/// Monomials by what they are called, with the features themselves among them.
#[derive(Clone, Debug)]
pub(super) struct TermSet {
    pub(super) name: &'static str,
    pub(super) monomials: Vec<Monomial>,
    /// Whether it has every feature that distances are measured in.
    pub(super) is_whole: bool,
}

/// Lists the sets for inputs of which some features, those kept, change.
pub(super) fn term_sets(inputs: &[Input], kept: &[usize]) -> Vec<TermSet> {
    let (mut blocks, mut rows, mut first) = (Vec::new(), Vec::new(), 0);
    for input in inputs {
        let len = input.kind.feature_len();
        let own = |most: usize| -> Vec<usize> {
            (first..first + most.min(len)).filter(|feature| kept.contains(feature)).collect()
        };
        let is_rotation = matches!(input.kind, InputKind::Rotation { .. });
        rows.push(own(if is_rotation { TWO_ROWS } else { len }));
        blocks.push(own(len));
        first += len;
    }
    let has_rotation = rows != blocks;
    let set = |name, monomials: Vec<Monomial>| {
        let is_whole = kept.iter().all(|&feature| monomials.contains(&vec![feature]));
        TermSet { name, monomials, is_whole }
    };
    let mut out = vec![set("linear", linear(&blocks))];
    let rows = if has_rotation { [linear(&rows), products(&rows)] } else { Default::default() };
    let [plain, by_others] = rows;
    let others = [
        ("two rows", plain),
        ("two rows x others", by_others),
        ("products", products(&blocks)),
        ("quadratic", quadratic(&blocks)),
    ];
    for (name, monomials) in others {
        let is_new = out.iter().all(|other: &TermSet| other.monomials != monomials);
        if is_new && !monomials.is_empty() {
            out.push(set(name, monomials));
        }
    }
    out
}

/// Makes the terms of monomials whose own factors are among them, and says where each has come to stand.
pub(super) fn terms(monomials: &[Monomial]) -> (Vec<Monomial>, Vec<Term>) {
    let mut sorted = monomials.to_vec();
    sorted.sort_by(|a, b| (a.len(), a).cmp(&(b.len(), b)));
    sorted.dedup();
    let place = |of: &[usize]| sorted.iter().position(|other| other == of).unwrap_or(0);
    let term = |monomial: &Monomial| match monomial.split_last() {
        None => Term::One,
        Some((&input, earlier)) => Term::Product { earlier: place(earlier), input },
    };
    let terms = sorted.iter().map(term).collect();
    (sorted, terms)
}

fn linear(blocks: &[Vec<usize>]) -> Vec<Monomial> {
    let features = blocks.iter().flatten().map(|&feature| vec![feature]);
    std::iter::once(Vec::new()).chain(features).collect()
}

/// Adds products of features of two inputs.
fn products(blocks: &[Vec<usize>]) -> Vec<Monomial> {
    let mut out = linear(blocks);
    for (number, block) in blocks.iter().enumerate() {
        for &other in blocks[number + 1..].iter().flatten() {
            out.extend(block.iter().map(|&feature| vec![feature, other]));
        }
    }
    out
}

/// Adds products of all pairs of features.
fn quadratic(blocks: &[Vec<usize>]) -> Vec<Monomial> {
    let all: Vec<usize> = blocks.concat();
    let pairs = |at: usize| all[at..].iter().map(move |&other| (at, other));
    let pairs = (0..all.len()).flat_map(pairs).map(|(at, other)| vec![all[at], other]);
    linear(blocks).into_iter().chain(pairs).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::rotations::Feature;
    use crate::scattered::sum::powers;

    #[test]
    fn sets_are_products_of_what_changes() {
        let input = |kind| Input { name: String::new(), kind, weight: 1.0 };
        let turn = InputKind::Rotation { feature: Feature::Matrix, order: None };
        let inputs = [turn, InputKind::Scalar, InputKind::Scalar].map(input);
        let kept: Vec<usize> = (0..11).filter(|feature| *feature != 4).collect();
        let sets = term_sets(&inputs, &kept);
        let sizes: Vec<_> = sets.iter().map(|set| (set.monomials.len(), set.is_whole)).collect();
        let expected = [
            (1 + 10, true),
            (1 + 7, false),
            (1 + 7 + 5 * 2 + 1, false),
            (1 + 10 + 8 * 2 + 1, true),
            (1 + 10 + 55, true),
        ];
        assert_eq!(sizes, expected);
        assert_eq!(term_sets(&inputs[1..], &[0, 1]).len(), 3, "no rotation, no rows");
        assert_eq!(term_sets(&inputs[1..2], &[0]).len(), 2, "no products");
    }

    #[test]
    fn terms_are_their_monomials() {
        let (sorted, terms) = terms(&[vec![0, 2], vec![2], vec![], vec![0], vec![2]]);
        assert_eq!(sorted, [vec![], vec![0], vec![2], vec![0, 2]]);
        assert_eq!(powers(&terms, &[3.0, 5.0, 7.0]), [1.0, 3.0, 7.0, 21.0]);
    }
}
