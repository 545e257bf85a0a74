//! Weights of vertices and frames: how much each counts in fits and in measured errors.

use super::Examples;
use super::validate::{is_weight, same};
use crate::Error;
use crate::formats::npz::read_numbers;
use std::path::Path;

/// Largest weight of a frame.
const MOST: f64 = 100.0;

/// Weights of items: equal, or numbers of mean 1.
#[derive(Clone, Copy, Debug)]
pub struct Importance<'a>(Option<&'a [f64]>);

impl<'a> Importance<'a> {
    /// Equal weights of 1.
    pub const UNIFORM: Self = Self(None);

    /// Creates weights from numbers; `None` for equal weights.
    pub fn by(numbers: Option<&'a [f64]>) -> Self {
        Self(numbers)
    }

    /// Returns the weight of an item.
    pub fn of(self, item: usize) -> f64 {
        self.0.map_or(1.0, |numbers| numbers[item])
    }

    /// Returns the weights of some items; `None` for equal weights.
    pub fn some(self, items: &[usize]) -> Option<Vec<f64>> {
        self.0.map(|numbers| items.iter().map(|&item| numbers[item]).collect())
    }
}

impl Examples {
    /// Returns the weights of the vertices.
    pub fn importance(&self) -> Importance<'_> {
        Importance::by(self.importance.as_deref())
    }

    /// Sets the weights of the vertices; only ratios matter.
    ///
    /// - `numbers`: V, or one per engine vertex; then the first copy of each vertex counts.
    ///
    /// # Errors
    /// The count is wrong, a number is negative or not finite, or all numbers are 0.
    pub fn set_importance(&mut self, mut numbers: Vec<f64>) -> Result<(), Error> {
        if numbers.len() == self.surface().engine_len() {
            numbers = self.surface().of_first_copies(&numbers);
        }
        same("vertices", "rest", self.vertex_len(), "importance", numbers.len())?;
        if let Some(vertex) = numbers.iter().position(|&number| !is_weight(number)) {
            let number = numbers[vertex];
            return Err(Error::value(format!(
                "the importance of vertex {vertex} must be finite and not negative, found {number}"
            )));
        }
        // Dividing by the largest number first keeps the sum finite.
        let largest = numbers.iter().copied().fold(0.0, f64::max);
        if largest == 0.0 {
            return Err(Error::value("the importance of every vertex is 0"));
        }
        numbers.iter_mut().for_each(|number| *number /= largest);
        let mean = numbers.iter().sum::<f64>() / numbers.len() as f64;
        numbers.iter_mut().for_each(|number| *number /= mean);
        self.importance = Some(numbers);
        Ok(())
    }

    /// Sets the number of times that each frame counts.
    ///
    /// - `numbers`: whole numbers from 1 to 100, N.
    ///
    /// # Errors
    /// The count is wrong, or a number is not allowed.
    pub fn repeat(&mut self, numbers: &[f64]) -> Result<(), Error> {
        same("frames", "vertices", self.frame_len(), "frame_weights", numbers.len())?;
        let is_whole = |number: &f64| number.fract() == 0.0 && (1.0..=MOST).contains(number);
        if let Some(frame) = numbers.iter().position(|number| !is_whole(number)) {
            let number = numbers[frame];
            let error = Error::value(format!(
                "array frame_weights has {number}, expected a whole number from 1 to {MOST}; to leave a frame out, \
                 give it split 1 or 2"
            ));
            return Err(error.in_frame(frame));
        }
        self.frame_weights = Some(numbers.iter().map(|&number| number as u8).collect());
        Ok(())
    }

    /// Repeats frames according to their weights.
    pub fn repeated(&self, frames: &[usize]) -> Vec<usize> {
        let weight = |frame: usize| self.frame_weights.as_ref().map_or(1, |all| all[frame].into());
        frames.iter().flat_map(|&frame| std::iter::repeat_n(frame, weight(frame))).collect()
    }
}

/// Reads one number per vertex from a `.npy` array, or from a `.txt` or `.csv` file with numbers between commas, spaces
/// or line ends.
///
/// # Errors
/// The file cannot be read, or contains anything else.
pub fn load_importance(path: &Path) -> Result<Vec<f64>, Error> {
    read_numbers(path, "importance").map_err(|error| error.in_file(path))
}

#[cfg(test)]
mod tests {
    use super::super::testing::triangle;
    use super::*;
    use crate::mesh::EngineMesh;

    #[test]
    fn only_ratios_matter() {
        let mut examples = triangle(1);
        assert_eq!(examples.importance().of(2), 1.0);
        examples.set_importance(vec![2e300, 4e300, 0.0]).unwrap();
        let importance = [0, 1, 2].map(|vertex| examples.importance().of(vertex));
        assert_eq!(importance, [1.0, 2.0, 0.0]);
    }

    #[test]
    fn importance_may_be_given_per_engine_vertex() {
        let mut examples = triangle(1);
        examples.engine = Some(EngineMesh {
            copy_of: vec![0, 1, 1, 2],
            triangles: vec![[0, 2, 3]],
            normals: None,
            tangents: None,
            uv: None,
        });
        examples.set_importance(vec![1.0, 2.0, 7.0, 0.0]).unwrap();
        assert_eq!([0, 1, 2].map(|vertex| examples.importance().of(vertex)), [1.0, 2.0, 0.0]);
        assert!(examples.set_importance(vec![1.0; 5]).is_err());
    }

    #[test]
    fn invalid_importance_is_refused() {
        let mut examples = triangle(1);
        for (numbers, words) in [
            (vec![1.0; 2], "rest has 3 vertices, importance has 2"),
            (
                vec![1.0, -2.0, 1.0],
                "importance of vertex 1 must be finite and not negative, found -2",
            ),
            (vec![1.0, 1.0, f64::NAN], "vertex 2"),
            (vec![0.0; 3], "the importance of every vertex is 0"),
        ] {
            let error = examples.set_importance(numbers).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
        assert!(examples.importance.is_none());
    }

    #[test]
    fn text_and_arrays_are_read() {
        let folder = std::env::temp_dir().join(format!("sinew-importance-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = |name: &str, bytes: &[u8]| {
            let path = folder.join(name);
            std::fs::write(&path, bytes).unwrap();
            load_importance(&path)
        };
        assert_eq!(file("a.txt", b"1\n0.5\n\n2e1\n").unwrap(), [1.0, 0.5, 20.0]);
        assert_eq!(file("a.csv", b"1, 0.5;2").unwrap(), [1.0, 0.5, 2.0]);
        let mut npy = b"\x93NUMPY\x01\x00\x46\x00".to_vec();
        npy.extend(
            format!("{:<69}\n", "{'descr': '<f4', 'fortran_order': False, 'shape': (2,), }")
                .bytes(),
        );
        npy.extend([1.0_f32, 0.25].map(f32::to_le_bytes).as_flattened());
        assert_eq!(file("a.npy", &npy).unwrap(), [1.0, 0.25]);
        for (name, bytes, words) in [
            (
                "b.txt",
                b"1 x 2".as_slice(),
                "array importance has \"x\" as number 1, expected a number",
            ),
            ("b.npy", b"1 x 2", "array importance"),
            ("b.png", b"", "expected a file that ends in .npy, .txt or .csv, found .png"),
        ] {
            let error = file(name, bytes).unwrap_err().to_string();
            assert!(error.contains(words) && error.contains(name), "{error}");
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn frames_repeat_by_their_weight() {
        let mut examples = triangle(4);
        assert_eq!(examples.repeated(&[1, 2]), [1, 2]);
        examples.repeat(&[1.0, 3.0, 1.0, 2.0]).unwrap();
        assert_eq!(examples.repeated(&[0, 1, 3]), [0, 1, 1, 1, 3, 3]);
    }

    #[test]
    fn invalid_frame_weights_are_refused_by_frame() {
        for bad in [0.0, -1.0, 1.5, 101.0, f64::NAN, f64::INFINITY] {
            let found = triangle(3).repeat(&[1.0, bad, 1.0]).unwrap_err();
            let words =
                format!("array frame_weights has {bad}, expected a whole number from 1 to 100");
            assert!(found.frame() == Some(1) && found.message().starts_with(&words), "{found}");
        }
        let short = triangle(3).repeat(&[1.0]).unwrap_err().to_string();
        assert!(short.contains("frame_weights"), "{short}");
    }
}
