//! The error of the trainer.

use std::borrow::Cow;
use std::error::Error as StdError;
use std::fmt::{Display, Formatter, Result};
use std::io;
use std::path::{Path, PathBuf};

/// A fault of a file, of examples, of a request or of a fit.
///
/// `Display` writes file, frame and message in one line. The message names the fault, the expected and the found value,
/// and the remedy.
#[derive(Debug)]
pub struct Error(Box<Fault>);

#[derive(Debug)]
struct Fault {
    kind: ErrorKind,
    file: Option<PathBuf>,
    frame: Option<i64>,
    message: Cow<'static, str>,
    cause: Option<Box<dyn StdError + Send + Sync>>,
}

/// Kind of an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// A file cannot be opened or read.
    Read,
    /// A file cannot be written.
    Write,
    /// A file, or a part of it, is damaged or not of its format.
    Damaged,
    /// A file uses a feature that is not read, or a request has no implementation.
    Unsupported,
    /// Something needed is absent: an array, a mesh, a joint, a clip, a frame.
    Missing,
    /// Two things that must agree differ: counts, meshes, skeletons, names.
    Mismatch,
    /// A number, word or shape is not allowed.
    Value,
    /// The data do not determine a result, or do not reach the requested accuracy.
    Fit,
    /// Something is too large for the file, the memory or the budget.
    Limit,
    /// The runtime refuses a call.
    Call,
}

/// Defines the constructor of each kind.
macro_rules! constructors {
    ($($name:ident $kind:ident,)*) => {$(
        #[doc = concat!("Creates an error of the kind [`ErrorKind::", stringify!($kind), "`].")]
        pub fn $name(message: impl Into<Cow<'static, str>>) -> Self {
            Self::new(ErrorKind::$kind, message)
        }
    )*};
}

impl Error {
    /// Creates an error from a message: a lower-case phrase without a full stop.
    pub fn new(kind: ErrorKind, message: impl Into<Cow<'static, str>>) -> Self {
        let message = message.into();
        Self(Box::new(Fault { kind, file: None, frame: None, message, cause: None }))
    }

    constructors! {
        damaged Damaged,
        unsupported Unsupported,
        missing Missing,
        mismatch Mismatch,
        value Value,
        fit Fit,
        limit Limit,
    }

    /// Creates the error of a file that cannot be opened or read.
    pub fn read(cause: io::Error) -> Self {
        Self::new(ErrorKind::Read, format!("cannot be read: {cause}")).caused_by(cause)
    }

    /// Creates the error of a file that cannot be written.
    pub fn write(cause: io::Error) -> Self {
        Self::new(ErrorKind::Write, format!("cannot be written: {cause}")).caused_by(cause)
    }

    /// Keeps the error that caused this one; the message must contain its text.
    pub fn caused_by(mut self, cause: impl StdError + Send + Sync + 'static) -> Self {
        self.0.cause = Some(Box::new(cause));
        self
    }

    /// Sets the faulty file, unless one is set.
    pub fn in_file(mut self, file: impl AsRef<Path>) -> Self {
        self.0.file.get_or_insert_with(|| file.as_ref().to_owned());
        self
    }

    /// Sets the frame index, unless a frame is set.
    pub fn in_frame(mut self, frame: usize) -> Self {
        self.0.frame.get_or_insert(frame as i64);
        self
    }

    /// Replaces the frame, such as an index by the number in the source.
    pub fn with_frame(mut self, number: impl FnOnce(i64) -> i64) -> Self {
        self.0.frame = self.0.frame.map(number);
        self
    }

    /// Puts a place before the message, as `mesh arm: vertex 3 has no weight`. File and frame stay before it.
    pub fn within(mut self, place: impl Display) -> Self {
        self.0.message = format!("{place}: {}", self.0.message).into();
        self
    }

    /// Returns the kind.
    pub fn kind(&self) -> ErrorKind {
        self.0.kind
    }

    /// Returns the faulty file, if the error is about one.
    pub fn file(&self) -> Option<&Path> {
        self.0.file.as_deref()
    }

    /// Returns the frame, if the error is about one: its number in the source, or its index if it has no number. `None`
    /// also if the message names the frame and its clip.
    pub fn frame(&self) -> Option<i64> {
        self.0.frame
    }

    /// Returns the message, without file and frame.
    pub fn message(&self) -> &str {
        &self.0.message
    }

    /// Returns the error that caused this one, if it was kept. Its text is part of the message.
    pub fn cause(&self) -> Option<&(dyn StdError + Send + Sync + 'static)> {
        self.0.cause.as_deref()
    }
}

impl Display for Error {
    fn fmt(&self, to: &mut Formatter<'_>) -> Result {
        if let Some(file) = &self.0.file {
            write!(to, "{}: ", file.display())?;
        }
        if let Some(frame) = self.0.frame {
            write!(to, "frame {frame}: ")?;
        }
        to.write_str(&self.0.message)
    }
}

// No `source`: the message has the text of the cause, and programs that print every source would repeat it.
impl StdError for Error {}

impl From<sinew_runtime::CallError> for Error {
    fn from(cause: sinew_runtime::CallError) -> Self {
        Self::new(ErrorKind::Call, cause.to_string()).caused_by(cause)
    }
}

impl From<sinew_runtime::FileError> for Error {
    fn from(cause: sinew_runtime::FileError) -> Self {
        Self::damaged(cause.to_string()).caused_by(cause)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_message_names_the_first_file_and_the_frame() {
        let error = Error::value("vertex 3 is not finite").within("array vertices").in_frame(7);
        assert_eq!(error.to_string(), "frame 7: array vertices: vertex 3 is not finite");
        let error = error.in_file("a.npz").in_file("b.npz").with_frame(|index| index + 100);
        assert_eq!(error.to_string(), "a.npz: frame 107: array vertices: vertex 3 is not finite");
        assert_eq!((error.kind(), error.frame()), (ErrorKind::Value, Some(107)));
        assert_eq!(error.file(), Some(Path::new("a.npz")));
    }

    #[test]
    fn a_cause_is_kept_and_printed_once() {
        let error = Error::read(io::ErrorKind::NotFound.into()).in_file("a.npz");
        let cause = error.cause().and_then(|cause| cause.downcast_ref::<io::Error>());
        assert_eq!(cause.map(io::Error::kind), Some(io::ErrorKind::NotFound));
        let chain = anyhow::Error::new(error);
        assert_eq!(format!("{chain:#}"), "a.npz: cannot be read: entity not found");
    }
}
