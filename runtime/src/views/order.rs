//! Numbers in the order of what belongs to them, in place.

/// Sorts numbers by a key, then by themselves: a heap of the last ones, taken apart from its root.
pub(super) fn sort(numbers: &mut [u16], key: impl Fn(u16) -> f32) {
    let is_before = |a: u16, b: u16| key(a).total_cmp(&key(b)).then(a.cmp(&b)).is_lt();
    for root in (0..numbers.len() / 2).rev() {
        sink(numbers, root, &is_before);
    }
    let mut heap = numbers;
    while let Some((last, rest)) = heap.split_last_mut() {
        let Some(first) = rest.first_mut() else { return };
        core::mem::swap(first, last);
        sink(rest, 0, &is_before);
        heap = rest;
    }
}

/// Lets a number sink to its place in a heap.
fn sink(heap: &mut [u16], root: usize, is_before: &impl Fn(u16, u16) -> bool) {
    let Some(own) = heap.get(root).copied() else { return };
    let mut at = root;
    loop {
        let child = 2 * at + 1;
        let next = match (heap.get(child), heap.get(child + 1)) {
            (Some(a), Some(b)) if is_before(*a, *b) => child + 1,
            (Some(_), _) => child,
            (None, _) => break,
        };
        let Some(other) = heap.get(next).copied().filter(|other| is_before(own, *other)) else {
            break;
        };
        if let Some(place) = heap.get_mut(at) {
            *place = other;
        }
        at = next;
    }
    if let Some(place) = heap.get_mut(at) {
        *place = own;
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    #[test]
    fn numbers_come_in_the_order_of_their_keys() {
        for len in 0..60u16 {
            let keys: Vec<f32> = (0..len).map(|i| f32::from(i * 7 % 13) - 4.0).collect();
            let mut found: Vec<u16> = (0..len).collect();
            sort(&mut found, |i| keys[usize::from(i)]);
            let mut expected: Vec<u16> = (0..len).collect();
            expected.sort_by(|a, b| keys[usize::from(*a)].total_cmp(&keys[usize::from(*b)]));
            assert_eq!(found, expected);
        }
    }
}
