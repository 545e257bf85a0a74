//! A set that is made, with its pictures.

use crate::page::picture::Picture;
use crate::views::set::ViewSet;

/// A set with its pictures, by the names that the set has for them.
pub(super) struct Made {
    pub(super) set: ViewSet,
    pub(super) pictures: Vec<(String, Picture)>,
}
