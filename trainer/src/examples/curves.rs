//! Curves of examples.

use super::Examples;
use crate::Error;

/// Choice of the curves that are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Curves<'a> {
    /// All curves of an `.npz`, or of a table beside a scene; none of a scene itself.
    #[default]
    Usual,
    /// All curves.
    All,
    /// No curve.
    None,
    /// The curves with these names, in this order.
    Named(&'a [String]),
}

impl Examples {
    /// Describes the size of a pose, as "7 joints, 2 curves".
    pub fn pose_size(&self) -> String {
        let count =
            |len: usize, word: &str| format!("{len} {word}{}", if len == 1 { "" } else { "s" });
        let joints = count(self.joint_len(), "joint");
        match self.curve_names.len() {
            0 => joints,
            curves => format!("{joints}, {}", count(curves, "curve")),
        }
    }

    /// Keeps the chosen curves of arrays.
    ///
    /// # Errors
    /// As [`Examples::keep_curves`].
    pub(super) fn choose_curves(&mut self, choice: Curves<'_>) -> Result<(), Error> {
        match choice {
            Curves::Usual | Curves::All => Ok(()),
            Curves::None => self.keep_curves(&[]),
            Curves::Named(names) => self.keep_curves(names),
        }
    }

    /// Keeps the named curves, in this order.
    ///
    /// # Errors
    /// A curve is missing; the message lists the curves of the examples.
    pub fn keep_curves(&mut self, names: &[String]) -> Result<(), Error> {
        let places = places(&self.curve_names, names)?;
        let frames = 0..self.frame_len();
        let of_frame = |frame| places.iter().map(|place| self.curves_of(frame)[*place]).collect();
        self.curves = frames.map(of_frame).collect::<Vec<Vec<f64>>>().concat();
        self.curve_names = names.to_vec();
        Ok(())
    }
}

/// Finds the places of named curves. A name in other case is found if no other known name is like it: programs write
/// ARKit's names as `jawOpen` or `JawOpen`.
///
/// # Errors
/// A curve is missing; the message lists the known curves.
pub(super) fn places(known: &[String], names: &[String]) -> Result<Vec<usize>, Error> {
    let place = |name: &String| {
        let same = known.iter().position(|own| own == name);
        let mut alike = (0..known.len()).filter(|&own| known[own].eq_ignore_ascii_case(name));
        let only = alike.next().filter(|_| alike.next().is_none());
        same.or(only).ok_or_else(|| {
            let found = match known {
                [] => "has none".to_owned(),
                names => format!("has {}", names.join(", ")),
            };
            Error::missing(format!("there is no curve {name}: it {found}"))
        })
    };
    names.iter().map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::super::testing::triangle;

    #[test]
    fn curves_are_kept_by_name_and_in_order() {
        let mut examples = triangle(2);
        examples.curve_names = ["smile", "blink", "jaw"].map(str::to_owned).to_vec();
        examples.curves = vec![0.1, 0.2, 0.3, 0.4, 0.5, 0.6];
        let error = examples.keep_curves(&["brow".to_owned()]).unwrap_err().to_string();
        assert_eq!(error, "there is no curve brow: it has smile, blink, jaw");
        examples.keep_curves(&["Jaw".to_owned(), "smile".to_owned()]).unwrap();
        assert_eq!(examples.curve_names, ["Jaw", "smile"], "the names that were asked for");
        assert_eq!(examples.curves, [0.3, 0.1, 0.6, 0.4]);
        assert_eq!(examples.pose_size(), "2 joints, 2 curves");
        examples.keep_curves(&[]).unwrap();
        assert_eq!(examples.pose_size(), "2 joints");
        assert!(examples.curves.is_empty() && examples.curves_of(1).is_empty());
        examples.validate().unwrap();
        let known = ["jaw", "Jaw", "blink"].map(str::to_owned);
        let places = |name: &str| super::places(&known, &[name.to_owned()]).ok();
        assert_eq!(["Jaw", "JAW", "BLINK"].map(places), [Some(vec![1]), None, Some(vec![2])]);
    }
}
