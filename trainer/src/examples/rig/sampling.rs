//! What of a scene is sampled, and when.

use super::error::ImportError;

/// What of a scene is sampled, and when.
pub(in crate::examples) struct Sampling<'a> {
    /// Frames a second; at the keys where none is given.
    pub(in crate::examples) fps: Option<f64>,
    /// The one clip to read; all of them where none is given.
    pub(in crate::examples) clip: Option<&'a str>,
    /// Whether the scene's own posed positions are wanted.
    pub(in crate::examples) shapes: bool,
}

impl Sampling<'_> {
    /// Tells whether a clip is to be read.
    pub(in crate::examples) fn takes(&self, clip: &str) -> bool {
        self.clip.is_none_or(|wanted| wanted == clip)
    }

    /// Names the clip that was asked for and is not there.
    ///
    /// # Errors
    /// [`ImportError::UnknownClip`], and [`ImportError::NoAnimation`] where there is none at all.
    pub(in crate::examples) fn check(&self, known: Vec<String>) -> Result<(), ImportError> {
        match self.clip {
            _ if known.is_empty() => Err(ImportError::NoAnimation),
            Some(name) if !known.iter().any(|clip| clip == name) => {
                Err(ImportError::UnknownClip { name: name.to_owned(), known })
            }
            _ => Ok(()),
        }
    }
}
