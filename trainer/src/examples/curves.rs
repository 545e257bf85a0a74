//! Curves of examples.

use super::Examples;
use crate::Error;

impl Examples {
    /// Keeps the named curves, in this order.
    ///
    /// # Errors
    /// A curve is missing; the message lists the curves of the examples.
    pub fn keep_curves(&mut self, names: &[String]) -> Result<(), Error> {
        let place = |name: &String| {
            self.curve_names.iter().position(|own| own == name).ok_or_else(|| {
                let found = match &self.curve_names[..] {
                    [] => "has none".to_owned(),
                    names => format!("has {}", names.join(", ")),
                };
                Error::missing(format!("there is no curve {name}: it {found}"))
            })
        };
        let places = names.iter().map(place).collect::<Result<Vec<usize>, _>>()?;
        let frames = 0..self.frame_len();
        let of_frame = |frame| places.iter().map(|place| self.curves_of(frame)[*place]).collect();
        self.curves = frames.map(of_frame).collect::<Vec<Vec<f64>>>().concat();
        self.curve_names = names.to_vec();
        Ok(())
    }
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
        examples.keep_curves(&["jaw".to_owned(), "smile".to_owned()]).unwrap();
        assert_eq!(examples.curves, [0.3, 0.1, 0.6, 0.4]);
        examples.keep_curves(&[]).unwrap();
        assert!(examples.curves.is_empty() && examples.curves_of(1).is_empty());
        examples.validate().unwrap();
    }
}
