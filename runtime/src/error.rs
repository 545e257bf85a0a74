//! Errors of calls.

use crate::named::named;
use core::fmt;

/// Reason why a call was refused. A refused call has written nothing except scratch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub struct CallError {
    /// Kind of the mistake.
    pub kind: CallErrorKind,
    /// Argument with the mistake.
    pub argument: Argument,
    /// Index of the element with the mistake.
    pub index: usize,
    /// Expected value, or the bound that was broken.
    pub expected: usize,
    /// Value found.
    pub found: usize,
}

/// Kinds of mistakes in a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub enum CallErrorKind {
    /// The argument's length, in its own elements, must be `expected`.
    Length,
    /// The argument must have at least `expected` elements; `usize::MAX` means that many or more.
    TooShort,
    /// Element `index` is not finite, or the result would not be.
    NonFinite,
    /// Quaternion `index`, or the quaternion of input `index` of a query, has no direction. It is
    /// zero, or too small or too large to square.
    ZeroRotation,
    /// Element `index` (or a range's end) is `found`; at most `expected` is allowed.
    OutOfRange,
    /// The stride is shorter than the attribute, which has `expected` floats.
    Stride,
    /// The attribute overlaps another attribute in memory.
    Overlap,
    /// The skin lacks the attribute, or the kernel has no variance.
    NoAttribute,
    /// The envelope's predictor, number `found`, does not have the stage.
    NoStage,
    /// The call has no output to write to.
    NoOutput,
    /// The names lack joint `index`, the root. The root has no parent to follow instead.
    NoRoot,
    /// The skeleton has joint `index` under another name: name `found` differs in prefix, case or
    /// separators.
    OtherName,
    /// The names contain only the root of the envelope's `expected` joints.
    NoJoints,
    /// The names lack curve `index`.
    NoCurve,
}

named! {
    /// Argument of a call, as [`CallError`] names it. The C ABI has the same numbers.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[repr(u8)]
    #[cfg_attr(not(feature = "internals"), non_exhaustive)]
    pub enum Argument {
        /// The call as a whole.
        Call = 0, "call";
        /// Skinning matrices.
        Pose = 1, "pose";
        /// Local transforms.
        Local = 2, "local transforms";
        /// Scratch, in floats.
        Scratch = 3, "scratch";
        /// The palette, in transforms.
        Palette = 4, "palette";
        /// Confidences.
        Confidences = 5, "confidences";
        /// Columns of the joints' transforms relative to the root.
        Relative = 6, "relative transforms";
        /// Rotation vectors of the joints.
        Rotations = 7, "rotations";
        /// Columns of the predicted gradients.
        Gradients = 8, "gradients";
        /// Pose features, in matrices.
        Features = 9, "features";
        /// The range of vertices.
        Vertices = 10, "vertices";
        /// Remap: the skin vertex that each engine vertex copies.
        Remap = 11, "remap";
        /// The caller's rest positions, and their largest distance from the file's.
        RestPositions = 12, "rest positions";
        /// The caller's rest normals.
        RestNormals = 13, "rest normals";
        /// The caller's rest tangents.
        RestTangents = 14, "rest tangents";
        /// Positions written, in floats.
        Positions = 15, "positions";
        /// Normals written, in floats.
        Normals = 16, "normals";
        /// Tangents written, in floats.
        Tangents = 17, "tangents";
        /// Numbers of a query.
        Query = 18, "query";
        /// Numbers of the outputs.
        Outputs = 19, "outputs";
        /// Derivatives.
        Jacobian = 20, "Jacobian";
        /// Variances.
        Variances = 21, "variances";
        /// Weights of shapes.
        Weights = 22, "shape weights";
        /// The prior, or the weight of one of its terms.
        Prior = 23, "prior";
        /// Pins. The index is a place in the list, or the vertex of a pin that is being added.
        Pins = 24, "pins";
        /// Control points.
        Points = 25, "points";
        /// Visibilities of control points.
        Visibility = 26, "visibility";
        /// Scores of key views.
        Scores = 27, "scores";
        /// Pixels of a picture.
        Pixels = 28, "pixels";
        /// Depths of pixels.
        Depths = 29, "depths";
        /// Samples of signals.
        Samples = 30, "samples";
        /// Names of the joints of the caller's skeleton.
        Names = 31, "names";
        /// Joint map: the caller's joint that drives each joint.
        Joints = 32, "joint map";
        /// Frames of the joints of the caller's skeleton.
        World = 33, "frames";
        /// The matrix of the root.
        Root = 34, "root matrix";
        /// Opacities and orders of layers.
        Layers = 35, "layers";
        /// Coverage left of each pixel by the layers that clip.
        Clips = 36, "clips";
        /// Pixels of a layer that is drawn into its own buffer.
        Group = 37, "group";
        /// Curves: their values, or the caller's curve that drives each.
        Curves = 38, "curves";
        /// Rotations of joints that stretch.
        Turns = 39, "joint rotations";
        /// Strains of joints that stretch.
        Strains = 40, "strains";
        /// Transforms of bones.
        Bones = 41, "bones";
    }
    /// Every argument.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) ALL;
    /// Returns the argument's name.
    pub name;
}

impl CallError {
    /// Makes an error of a kind about an argument; the other fields are 0.
    pub(crate) const fn new(kind: CallErrorKind, argument: Argument) -> Self {
        Self { kind, argument, index: 0, expected: 0, found: 0 }
    }

    pub(crate) const fn at(self, index: usize) -> Self {
        Self { index, ..self }
    }

    pub(crate) const fn values(self, expected: usize, found: usize) -> Self {
        Self { expected, found, ..self }
    }
}

impl Argument {
    pub(crate) const fn check_len(self, expected: usize, found: usize) -> Result<(), CallError> {
        if found == expected {
            return Ok(());
        }
        Err(CallError::new(CallErrorKind::Length, self).values(expected, found))
    }

    pub(crate) const fn check_least(self, least: usize, found: usize) -> Result<(), CallError> {
        if found >= least {
            return Ok(());
        }
        Err(CallError::new(CallErrorKind::TooShort, self).values(least, found))
    }

    /// Refuses the argument if one of its elements, at index `unsound`, is not finite.
    pub(crate) fn check_finite(self, unsound: Option<usize>) -> Result<(), CallError> {
        unsound.map_or(Ok(()), |at| Err(CallError::new(CallErrorKind::NonFinite, self).at(at)))
    }

    /// Returns the unit of a length.
    const fn unit(self) -> &'static str {
        match self {
            Self::Positions | Self::Normals | Self::Tangents => "floats",
            _ => "elements",
        }
    }

    /// Returns the name of an element, and the name of an element that is a rotation.
    const fn elements(self) -> [&'static str; 2] {
        match self {
            Self::Query | Self::Outputs | Self::Jacobian | Self::Variances => ["number", "input"],
            Self::Weights | Self::Prior => ["shape"; 2],
            Self::Pins => ["pin"; 2],
            Self::Points | Self::Visibility => ["point"; 2],
            Self::Scores => ["view"; 2],
            Self::Pixels | Self::Depths => ["pixel"; 2],
            Self::Samples => ["number"; 2],
            Self::Curves => ["curve"; 2],
            _ => ["joint"; 2],
        }
    }
}

impl core::error::Error for CallError {}

impl fmt::Display for CallError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, argument, index, expected, found } = *self;
        let name = argument.name();
        let [element, rotation] = argument.elements();
        match kind {
            CallErrorKind::Length => {
                write!(f, "{name}: expected {expected} elements, found {found}")
            }
            CallErrorKind::TooShort => {
                let elements = argument.unit();
                write!(f, "{name}: expected at least {expected} {elements}, found {found}")
            }
            CallErrorKind::NonFinite => write!(f, "{name}: {element} {index} is not finite"),
            CallErrorKind::ZeroRotation => {
                write!(f, "{name}: the rotation of {rotation} {index} has no direction")
            }
            CallErrorKind::OutOfRange if argument == Argument::RestPositions => {
                f.write_str("rest offset: expected a finite number of at least 0")
            }
            CallErrorKind::OutOfRange if argument == Argument::Vertices && index > found => {
                write!(f, "{name}: the range {index}..{found} ends before its start")
            }
            CallErrorKind::OutOfRange => {
                write!(f, "{name}: expected at most {expected}, found {found} at {index}")
            }
            CallErrorKind::Stride => write!(
                f,
                "{name}: a stride of {found} floats is shorter than the attribute's {expected}"
            ),
            CallErrorKind::Overlap => write!(f, "{name}: overlap another attribute in memory"),
            CallErrorKind::NoAttribute => write!(f, "{name}: the part has none"),
            CallErrorKind::NoStage => {
                write!(f, "the stage is not part of the envelope's predictor, number {found}")
            }
            CallErrorKind::NoOutput => f.write_str("nothing to write to"),
            CallErrorKind::NoRoot => {
                write!(
                    f,
                    "{name}: joint {index}, the root, is not among them and can follow no other: compare them with \
                     Envelope::joint_name"
                )
            }
            CallErrorKind::OtherName => write!(
                f,
                "{name}: name {found} is joint {index} with another prefix, case or separators: give the names as \
                 Envelope::joint_name has them"
            ),
            CallErrorKind::NoJoints => write!(
                f,
                "{name}: the root alone of {expected} joints is among them: compare them with Envelope::joint_name"
            ),
            CallErrorKind::NoCurve => write!(
                f,
                "{name}: curve {index} is not among them: compare them with Envelope::curve_name"
            ),
        }
    }
}
