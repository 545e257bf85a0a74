//! What can be wrong with a picture in layers.

/// A picture in layers that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum LayeredError {
    /// It is no archive.
    #[error("expected an OpenRaster file, which is a zip archive: {0}")]
    Archive(String),
    /// The archive lacks a file.
    #[error("has no {0}: expected an OpenRaster file")]
    Missing(String),
    /// The list of layers cannot be read.
    #[error("stack.xml: {0}")]
    Stack(String),
    /// It is no Photoshop file.
    #[error("expected a Photoshop file, which begins with 8BPS")]
    NoPsd,
    /// The bytes contradict each other.
    #[error("is damaged: {0}")]
    Damaged(String),
    /// A feature is not read.
    #[error("has {found}, expected {expected}: convert it and save it again")]
    Unread {
        /// The feature of the file.
        found: String,
        /// The features that are read.
        expected: &'static str,
    },
    /// The picture or a part of it is too large.
    #[error("is too large: {0}")]
    TooLarge(String),
    /// There are no layers.
    #[error("has no layers: save it with layers, or save a PNG")]
    Empty,
    /// Two layers have one name.
    #[error("has two layers \"{0}\": give each its own name")]
    Twice(String),
    /// No layer has a name.
    #[error("has no layer \"{name}\": its layers are {found}")]
    NoLayer {
        /// The name.
        name: String,
        /// The names that are there.
        found: String,
    },
    /// Several layers have a name.
    #[error("has several layers \"{name}\": write one of {found}")]
    Several {
        /// The name.
        name: String,
        /// Their paths.
        found: String,
    },
    /// The name is a group's.
    #[error("\"{0}\" is a group: merge it, or name its layers")]
    Group(String),
    /// A layer is clipped to a group, to several layers, or to nothing.
    #[error("layer \"{layer}\" is clipped to {base}, expected one layer below it in its group")]
    Clip {
        /// The layer.
        layer: String,
        /// What is below it.
        base: String,
    },
    /// A layer has a blend mode that is not read.
    #[error("layer \"{layer}\" has the blend mode {mode}, expected normal: merge it down")]
    Blend {
        /// The layer.
        layer: String,
        /// Its mode as the file writes it.
        mode: String,
    },
    /// The picture of a layer cannot be read.
    #[error("layer \"{layer}\": {what}")]
    Picture {
        /// The layer.
        layer: String,
        /// The fault.
        what: String,
    },
}
