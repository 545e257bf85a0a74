//! What of a scene is sampled, and when.

use super::error::SceneError;

/// What of a scene is sampled, and when.
pub(crate) struct Sampling<'a> {
    /// Frames a second; at the keys where none is given.
    pub(crate) fps: Option<f64>,
    /// The clips to read; all of them where none is given.
    pub(crate) clips: &'a [String],
    /// Whether the scene's own posed positions are wanted.
    pub(crate) shapes: bool,
    /// Whether the one frame is what the scene shows without any clip.
    pub(crate) still: bool,
    /// Whether clips are sampled to be played, and not to be learned from.
    pub(crate) played: bool,
}

impl Sampling<'_> {
    /// Tells whether a clip is to be read.
    pub(crate) fn takes(&self, clip: &str) -> bool {
        self.clips.is_empty() || self.clips.iter().any(|wanted| wanted == clip)
    }

    /// Names a clip that was asked for and is not there.
    ///
    /// # Errors
    /// [`SceneError::UnknownClip`], and [`SceneError::NoAnimation`] where there is none at all.
    pub(crate) fn check(&self, known: Vec<String>) -> Result<(), SceneError> {
        if known.is_empty() {
            return Err(SceneError::NoAnimation);
        }
        match self.clips.iter().find(|name| !known.contains(name)) {
            Some(name) => Err(SceneError::UnknownClip { name: name.clone(), known }),
            None => Ok(()),
        }
    }
}
