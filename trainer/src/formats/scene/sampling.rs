//! What of a scene is sampled, and when.

use super::error::SceneError;

/// What of a scene is sampled, and when.
pub(crate) struct Sampling<'a> {
    /// Frames a second; at the keys where none is given.
    pub(crate) fps: Option<f64>,
    /// The one clip to read; all of them where none is given.
    pub(crate) clip: Option<&'a str>,
    /// Whether the scene's own posed positions are wanted.
    pub(crate) shapes: bool,
}

impl Sampling<'_> {
    /// Tells whether a clip is to be read.
    pub(crate) fn takes(&self, clip: &str) -> bool {
        self.clip.is_none_or(|wanted| wanted == clip)
    }

    /// Names the clip that was asked for and is not there.
    ///
    /// # Errors
    /// [`SceneError::UnknownClip`], and [`SceneError::NoAnimation`] where there is none at all.
    pub(crate) fn check(&self, known: Vec<String>) -> Result<(), SceneError> {
        match self.clip {
            _ if known.is_empty() => Err(SceneError::NoAnimation),
            Some(name) if !known.iter().any(|clip| clip == name) => {
                Err(SceneError::UnknownClip { name: name.to_owned(), known })
            }
            _ => Ok(()),
        }
    }
}
