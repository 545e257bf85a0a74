//! A few of many, evenly spread.

/// Lists at most `most` of the numbers below `len`, evenly apart, ascending.
pub(crate) fn spread(len: usize, most: usize) -> Vec<usize> {
    let count = len.min(most);
    (0..count).map(|number| number * len / count).collect()
}
