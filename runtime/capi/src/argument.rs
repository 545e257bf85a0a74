//! Arguments that an error can name.

use sinew_runtime::Argument;

/// The argument that an error is about. Numbers from 50 on are arguments that only C has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u32)]
pub enum sinew_argument {
    /// No single argument.
    Call = 0,
    /// Skinning matrices of the joints.
    Pose = 1,
    /// Local transforms of the joints.
    Local = 2,
    /// Scratch; lengths are in floats.
    Scratch = 3,
    /// The palette; lengths are in transforms.
    Palette = 4,
    /// Confidences.
    Confidences = 5,
    /// Intermediate result: columns of the joints' transforms. No function of this library takes it.
    Relative = 6,
    /// Intermediate result: rotation vectors. No function of this library takes it.
    Rotations = 7,
    /// Intermediate result: columns of gradients. No function of this library takes it.
    Gradients = 8,
    /// Intermediate result: pose features. No function of this library takes it.
    Features = 9,
    /// The range of vertices, a vertex, or the scratch for their positions.
    Vertices = 10,
    /// The map from engine vertices to skin vertices.
    Remap = 11,
    /// The caller's rest positions, or their distance from the file's.
    RestPositions = 12,
    /// The caller's rest normals.
    RestNormals = 13,
    /// The caller's rest tangents.
    RestTangents = 14,
    /// Output positions; lengths are in floats.
    Positions = 15,
    /// Output normals; lengths are in floats.
    Normals = 16,
    /// Output tangents; lengths are in floats.
    Tangents = 17,
    /// Numbers of a kernel's query.
    Query = 18,
    /// Numbers of a kernel's outputs.
    Outputs = 19,
    /// Derivatives of a kernel's values.
    Jacobian = 20,
    /// Variances of a kernel's values.
    Variances = 21,
    /// Weights of shapes.
    ShapeWeights = 22,
    /// A prior, or the weight of a term of a pin job.
    Prior = 23,
    /// Pins.
    Pins = 24,
    /// Control points.
    Points = 25,
    /// Visibilities of control points.
    Visibility = 26,
    /// Scores of key views.
    Scores = 27,
    /// Pixels of a picture.
    Pixels = 28,
    /// Depths of pixels.
    Depths = 29,
    /// Samples of signals.
    Samples = 30,
    /// Names of the joints of the caller's skeleton, or of the caller's curves.
    Names = 31,
    /// Map from the file's joints to those of the caller's skeleton, or the joints' parents.
    Joints = 32,
    /// Frames of the joints of the caller's skeleton.
    World = 33,
    /// The root matrix.
    Root = 34,
    /// Opacities and orders of layers.
    Layers = 35,
    /// Scratch for the clipping of layers, in bytes.
    Clips = 36,
    /// Scratch for layers that are drawn separately, in pixels.
    Group = 37,
    /// Values of the curves, or the map from the file's curves to the caller's.
    Curves = 38,
    /// Intermediate result: rotations of joints that stretch. No function of this library takes it.
    Turns = 39,
    /// Intermediate result: strains of joints that stretch. No function of this library takes it.
    Strains = 40,
    /// Bones of translation, rotation and scale.
    Bones = 41,

    /// Memory for an object; lengths are in bytes.
    Memory = 50,
    /// The file; lengths are in bytes.
    File = 51,
    /// Limits.
    Limits = 52,
    /// A model.
    Model = 53,
    /// An envelope.
    Envelope = 54,
    /// A skin.
    Skin = 55,
    /// A name; lengths are in bytes.
    Name = 56,
    /// Index of a joint.
    Joint = 57,
    /// Index of a named range.
    Range = 58,
    /// Part and kind of a section.
    Section = 59,
    /// A job.
    Job = 60,
    /// Palette indices of influences.
    Indices = 61,
    /// Weights of influences.
    Weights = 62,
    /// Memory for a result.
    Result = 64,
    /// Memory for a second result.
    SecondResult = 65,
    /// A kernel.
    Kernel = 66,
    /// Index of a kernel's input.
    Input = 67,
    /// Index of a kernel's output.
    Output = 68,
    /// Index of a shape, or the layout of samples.
    Shape = 69,
    /// Views.
    Views = 70,
    /// Index of a map.
    Map = 71,
    /// A filter.
    Filter = 72,
    /// A kind of part.
    Kind = 73,
    /// Index of a curve.
    Curve = 74,
    /// Number of an attribute.
    Attribute = 75,
    /// Tangent coefficients; lengths are in floats.
    Coefficients = 76,
}

/// Name of each argument.
const NAMES: [(sinew_argument, &str); 68] = {
    use sinew_argument as A;
    [
        (A::Call, "call"),
        (A::Pose, "pose"),
        (A::Local, "local transforms"),
        (A::Scratch, "scratch"),
        (A::Palette, "palette"),
        (A::Confidences, "confidences"),
        (A::Relative, "relative transforms"),
        (A::Rotations, "rotations"),
        (A::Gradients, "gradients"),
        (A::Features, "features"),
        (A::Vertices, "vertices"),
        (A::Remap, "remap"),
        (A::RestPositions, "rest positions"),
        (A::RestNormals, "rest normals"),
        (A::RestTangents, "rest tangents"),
        (A::Positions, "positions"),
        (A::Normals, "normals"),
        (A::Tangents, "tangents"),
        (A::Query, "query"),
        (A::Outputs, "outputs"),
        (A::Jacobian, "Jacobian"),
        (A::Variances, "variances"),
        (A::ShapeWeights, "shape weights"),
        (A::Prior, "prior"),
        (A::Pins, "pins"),
        (A::Points, "points"),
        (A::Visibility, "visibility"),
        (A::Scores, "scores"),
        (A::Pixels, "pixels"),
        (A::Depths, "depths"),
        (A::Samples, "samples"),
        (A::Names, "names"),
        (A::Joints, "joint map"),
        (A::World, "frames"),
        (A::Root, "root matrix"),
        (A::Layers, "layers"),
        (A::Clips, "clips"),
        (A::Group, "group"),
        (A::Curves, "curves"),
        (A::Turns, "joint rotations"),
        (A::Strains, "strains"),
        (A::Bones, "bones"),
        (A::Memory, "memory"),
        (A::File, "file"),
        (A::Limits, "limits"),
        (A::Model, "model"),
        (A::Envelope, "envelope"),
        (A::Skin, "skin"),
        (A::Name, "name"),
        (A::Joint, "joint"),
        (A::Range, "range"),
        (A::Section, "section"),
        (A::Job, "job"),
        (A::Indices, "indices"),
        (A::Weights, "weights"),
        (A::Result, "result"),
        (A::SecondResult, "second result"),
        (A::Kernel, "kernel"),
        (A::Input, "input"),
        (A::Output, "output"),
        (A::Shape, "shape"),
        (A::Views, "views"),
        (A::Map, "map"),
        (A::Filter, "filter"),
        (A::Kind, "kind"),
        (A::Curve, "curve"),
        (A::Attribute, "attribute"),
        (A::Coefficients, "tangent coefficients"),
    ]
};

impl sinew_argument {
    /// Returns the argument's name.
    pub(crate) fn name(self) -> &'static str {
        let found = NAMES.iter().find(|(known, _)| *known == self);
        found.map_or("", |(_, name)| name)
    }
}

impl From<Argument> for sinew_argument {
    fn from(argument: Argument) -> Self {
        match argument {
            Argument::Call => Self::Call,
            Argument::Pose => Self::Pose,
            Argument::Local => Self::Local,
            Argument::Scratch => Self::Scratch,
            Argument::Palette => Self::Palette,
            Argument::Confidences => Self::Confidences,
            Argument::Relative => Self::Relative,
            Argument::Rotations => Self::Rotations,
            Argument::Gradients => Self::Gradients,
            Argument::Features => Self::Features,
            Argument::Vertices => Self::Vertices,
            Argument::Remap => Self::Remap,
            Argument::RestPositions => Self::RestPositions,
            Argument::RestNormals => Self::RestNormals,
            Argument::RestTangents => Self::RestTangents,
            Argument::Positions => Self::Positions,
            Argument::Normals => Self::Normals,
            Argument::Tangents => Self::Tangents,
            Argument::Query => Self::Query,
            Argument::Outputs => Self::Outputs,
            Argument::Jacobian => Self::Jacobian,
            Argument::Variances => Self::Variances,
            Argument::Weights => Self::ShapeWeights,
            Argument::Prior => Self::Prior,
            Argument::Pins => Self::Pins,
            Argument::Points => Self::Points,
            Argument::Visibility => Self::Visibility,
            Argument::Scores => Self::Scores,
            Argument::Pixels => Self::Pixels,
            Argument::Depths => Self::Depths,
            Argument::Samples => Self::Samples,
            Argument::Names => Self::Names,
            Argument::Joints => Self::Joints,
            Argument::World => Self::World,
            Argument::Root => Self::Root,
            Argument::Layers => Self::Layers,
            Argument::Clips => Self::Clips,
            Argument::Group => Self::Group,
            Argument::Curves => Self::Curves,
            Argument::Turns => Self::Turns,
            Argument::Strains => Self::Strains,
            Argument::Bones => Self::Bones,
        }
    }
}
