//! Elements: what pictures are cut into.

use super::error::SetError;

/// A triangle or a convex quad, by its points' numbers in turn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Element {
    /// Three points.
    Triangle([usize; 3]),
    /// Four points.
    Quad([usize; 4]),
}

impl Element {
    /// Makes elements of a polygon: itself, or, of more corners than four, triangles about its first.
    ///
    /// # Errors
    /// [`SetError::Element`]: it has fewer than three points, one that there is not, or one twice.
    pub fn of_polygon(
        element: usize,
        polygon: &[usize],
        points: usize,
    ) -> Result<Vec<Self>, SetError> {
        let wrong = |what: String| SetError::Element { element, what };
        if let Some(point) = polygon.iter().find(|point| **point >= points) {
            return Err(wrong(format!("point {point}, of {points}")));
        }
        let twice = (1..polygon.len()).find(|&at| polygon[..at].contains(&polygon[at]));
        if let Some(at) = twice {
            return Err(wrong(format!("point {} is there twice", polygon[at])));
        }
        match *polygon {
            [a, b, c] => Ok(vec![Self::Triangle([a, b, c])]),
            [a, b, c, d] => Ok(vec![Self::Quad([a, b, c, d])]),
            [first, _, _, _, _, ..] => {
                let fan = polygon[1..].windows(2).map(|pair| [first, pair[0], pair[1]]);
                Ok(fan.map(Self::Triangle).collect())
            }
            _ => Err(wrong(format!("expected 3 points or more, found {}", polygon.len()))),
        }
    }

    /// Lists its points.
    pub fn points(&self) -> &[usize] {
        match self {
            Self::Triangle(points) => points,
            Self::Quad(points) => points,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_become_triangles_about_their_first_corner() {
        let found = Element::of_polygon(0, &[5, 1, 2, 3, 4], 6).unwrap();
        let expected = [[5, 1, 2], [5, 2, 3], [5, 3, 4]].map(Element::Triangle);
        assert_eq!(found, expected);
        assert_eq!(Element::of_polygon(0, &[3, 2, 1, 0], 4).unwrap().len(), 1);
    }

    #[test]
    fn points_that_make_no_element_are_named() {
        for (polygon, what) in [
            (&[0, 1][..], "expected 3 points or more, found 2"),
            (&[0, 1, 7], "point 7, of 4"),
            (&[0, 1, 2, 1], "point 1 is there twice"),
        ] {
            let refused = Element::of_polygon(9, polygon, 4).unwrap_err();
            assert_eq!(refused.to_string(), format!("element 9: {what}"));
        }
    }
}
