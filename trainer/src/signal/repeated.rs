//! Finds observations that earlier ones determine under any covariance: repetitions, and averages over boxes that other
//! boxes add up to.
//!
//! Let F be an integral of the function. An average over [a, b] times b - a is F(b) - F(a), an edge of a graph between
//! the ends of boxes. A path of other edges from a to b determines the average. Values and derivatives are determined
//! only by repetition.

use super::functional::Functional;
use crate::Error;

/// Two places within this fraction of the largest magnitude are the same; the rounding errors of f64 sums are smaller.
const ONE_PLACE: f64 = 1e-12;
/// Relative tolerance for agreement of observations: a few units in the last place of f32.
const AGREE: f64 = 1e-6;
/// Most observation numbers that a message lists.
const LISTED: usize = 8;

/// Lists the observations that earlier ones do not determine.
///
/// - `values`: value of each functional, n.
///
/// # Errors
/// If an observation differs from the value that earlier ones imply.
pub(super) fn independent(functionals: &[Functional], values: &[f64]) -> Result<Vec<usize>, Error> {
    let mut accepted = Accepted::new(functionals);
    let mut out = Vec::with_capacity(values.len());
    for (at, found) in values.iter().copied().enumerate() {
        let Some(others) = accepted.determined(at) else {
            accepted.insert(at);
            out.push(at);
            continue;
        };
        let shares = others.iter().map(|(other, share)| share * values[*other]);
        let (expected, magnitude) =
            shares.fold((0.0, found.abs()), |(sum, most), x| (sum + x, most.max(x.abs())));
        if (expected - found).abs() > AGREE * magnitude {
            let others: Vec<usize> = others.into_iter().map(|(other, _)| other).collect();
            return Err(contradiction(&others, at, expected, found));
        }
    }
    Ok(out)
}

/// Returns the error of an observation that contradicts the value that others imply, for any covariance.
///
/// - `others`: observations that imply the value; a single one measures the same quantity.
/// - `expected`: value implied by the others.
/// - `found`: value of the observation.
fn contradiction(others: &[usize], at: usize, expected: f64, found: f64) -> Error {
    let remedy = "leave one out, or give a noise";
    let [first] = others else {
        // Sums have f64 rounding errors, so f32 digits are shown.
        let (others, expected) = (listed(others), expected as f32);
        return Error::mismatch(format!(
            "observation {at} contradicts observations {others}: they give {expected} and it says {found}; {remedy}"
        ));
    };
    Error::mismatch(format!(
        "observations {first} and {at} contradict each other: they are of one thing and say {expected} and {found}; \
         {remedy}"
    ))
}

/// Lists observation numbers; counts those after the first few.
fn listed(of: &[usize]) -> String {
    let first: Vec<String> = of.iter().take(LISTED).map(usize::to_string).collect();
    let first = first.join(", ");
    match of.len().saturating_sub(LISTED) {
        0 => first,
        more => format!("{first}, {more} more"),
    }
}

/// Returns the least distance between the ends of observations; `None` if all are at one place.
pub(super) fn least_distance(functionals: &[Functional]) -> Option<f64> {
    let (order, one) = sorted(functionals);
    let distances = order.windows(2).map(|pair| pair[1].0 - pair[0].0);
    distances.filter(|distance| *distance > one).min_by(f64::total_cmp)
}

/// Accepted observations, as a graph of places.
struct Accepted<'a> {
    functionals: &'a [Functional],
    /// Place indices of each observation's ends, n.
    ends: Vec<[usize; 2]>,
    /// Accepted values and derivatives at each place.
    at: Vec<Vec<usize>>,
    /// Accepted averages with an end at each place: observation, and the place of the other end.
    boxes: Vec<Vec<(usize, usize)>>,
}

impl<'a> Accepted<'a> {
    fn new(functionals: &'a [Functional]) -> Self {
        let (order, one) = sorted(functionals);
        let mut ends = vec![[0; 2]; functionals.len()];
        let (mut place, mut before) = (0, order.first().map_or(0.0, |first| first.0));
        for (x, of, side) in order {
            place += usize::from(x - before > one);
            before = x;
            ends[of][side] = place;
        }
        let (at, boxes) = (vec![Vec::new(); place + 1], vec![Vec::new(); place + 1]);
        Self { functionals, ends, at, boxes }
    }

    fn insert(&mut self, of: usize) {
        let [from, to] = self.ends[of];
        match self.functionals[of] {
            Functional::Average { .. } => {
                self.boxes[from].push((of, to));
                self.boxes[to].push((of, from));
            }
            Functional::Value { .. } | Functional::Derivative { .. } => self.at[from].push(of),
        }
    }

    /// Lists accepted observations that determine another, with their weights; `None` if nothing determines the other.
    fn determined(&self, of: usize) -> Option<Vec<(usize, f64)>> {
        let [from, to] = self.ends[of];
        let own = &self.functionals[of];
        let Functional::Average { .. } = own else {
            let kind = |of: &Functional| std::mem::discriminant(of);
            let is_same = |other: &&usize| kind(&self.functionals[**other]) == kind(own);
            return self.at[from].iter().find(is_same).map(|other| vec![(*other, 1.0)]);
        };
        // How the search reached each place: by an observation, from a place.
        let mut reached: Vec<Option<(usize, usize)>> = vec![None; self.boxes.len()];
        let mut open = vec![from];
        while let Some(place) = open.pop() {
            for &(by, next) in &self.boxes[place] {
                if next != from && reached[next].is_none() {
                    reached[next] = Some((by, place));
                    open.push(next);
                }
            }
        }
        let (mut place, mut path) = (to, Vec::new());
        while let Some((by, before)) = reached[place] {
            let forward = if self.ends[by][0] == before { 1.0 } else { -1.0 };
            path.push((by, forward * width(&self.functionals[by]) / width(own)));
            place = before;
        }
        path.sort_by_key(|(by, _)| *by);
        (!path.is_empty()).then_some(path)
    }
}

/// Lists the ends of observations in ascending order, each with its observation and side. Also returns the distance
/// within which two ends are the same place.
fn sorted(functionals: &[Functional]) -> (Vec<(f64, usize, usize)>, f64) {
    let ends = functionals.iter().enumerate();
    let ends = ends.flat_map(|(of, functional)| {
        let [from, to] = functional.ends();
        [(from, of, 0), (to, of, 1)]
    });
    let mut order: Vec<_> = ends.collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let most = order.iter().fold(0.0f64, |most, (x, ..)| most.max(x.abs()));
    (order, ONE_PLACE * most)
}

fn width(of: &Functional) -> f64 {
    let [from, to] = of.ends();
    to - from
}

#[cfg(test)]
mod tests {
    use super::*;

    fn average(from: f64, to: f64) -> Functional {
        Functional::Average { from, to }
    }

    fn value(at: f64) -> Functional {
        Functional::Value { at }
    }

    #[test]
    fn averages_that_others_add_up_to_are_left_out_in_any_order() {
        let functionals = [
            average(0.0, 2.0),
            value(1.0),
            average(0.0, 1.0),
            average(1.0, 2.0),
            average(2.0, 3.0),
        ];
        assert_eq!(independent(&functionals, &[2.0, 9.0, 1.0, 3.0, 4.0]).unwrap(), [0, 1, 2, 4]);
        // The difference of two averages determines a part; the ends differ by rounding.
        let parts = [average(0.0, 0.1), average(0.0, 0.1 + 0.2), average(0.1, 0.3)];
        assert_eq!(independent(&parts, &[4.0, 2.0, 1.0]).unwrap(), [0, 1]);
        // Overlapping boxes determine nothing.
        let overlapping = [average(0.0, 2.0), average(1.0, 3.0), average(0.0, 3.0)];
        assert_eq!(independent(&overlapping, &[1.0, 5.0, 7.0]).unwrap(), [0, 1, 2]);
    }

    #[test]
    fn contradictions_name_the_implying_observations() {
        let functionals =
            [average(0.0, 1.0), average(5.0, 6.0), average(1.0, 2.0), average(0.0, 2.0)];
        let error = independent(&functionals, &[1.0, 8.0, 3.0, 5.0]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "observation 3 contradicts observations 0, 2: they give 2 and it says 5; leave one out, or give a noise"
        );
        let slopes = [Functional::Derivative { at: 1.0 }, value(1.0), value(1.0 + 1e-14)];
        let error = independent(&slopes, &[0.0, 1.0, 1.5]).unwrap_err();
        assert!(
            error.message().starts_with("observations 1 and 2 contradict each other"),
            "{error}"
        );
        assert_eq!(independent(&slopes, &[0.0, 1.0, 1.0]).unwrap(), [0, 1]);
    }

    #[test]
    fn the_least_distance_ignores_rounding() {
        let of = [average(0.0, 4.0), value(4.5), value(4.5 + 1e-14), value(7.0)];
        assert_eq!(least_distance(&of), Some(0.5));
        assert_eq!(least_distance(&[value(2.0)]), None);
    }
}
