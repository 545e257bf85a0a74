//! The kinds of sections: their names and numbers, and what each is an array of.

use super::tables::Element;

/// A kind of section. A number never changes meaning; which part has which is the part's affair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum SectionKind {
    /// Name of the part, and of what it consists of: joints, ranges of vertices, inputs and outputs.
    Names = 1,
    /// Parent of each joint, evaluation order, and rank of each joint in it.
    Hierarchy = 2,
    /// Inverse bind matrices.
    InverseBinds = 3,
    /// Rest positions.
    RestPositions = 4,
    /// Rest normals.
    RestNormals = 5,
    /// Rest tangents with handedness.
    RestTangents = 6,
    /// Palette index of each influence.
    InfluenceIndices = 7,
    /// Weight of each influence.
    InfluenceWeights = 8,
    /// Key predictors.
    Keys = 9,
    /// Gradients to palette.
    C1 = 10,
    /// Joints to palette.
    C2 = 11,
    /// Rest box of what each transform of the palette moves.
    RestBoxes = 12,
    /// Largest rotation of each joint in training, and how far it came from its parent.
    PoseRanges = 13,
    /// Origin of each joint in the rest pose.
    Origins = 14,
    /// Groups of proxies that share a kernel map.
    Groups = 15,
    /// Numbers of the kernel maps, group by group.
    Corrections = 16,
    /// Counts of an envelope.
    EnvelopeCounts = 17,
    /// What an envelope's fit was measured to reach.
    Certificate = 18,
    /// Counts of a skin.
    SkinCounts = 19,
    /// Ranges of vertices: the meshes that the artist made.
    Ranges = 20,
    /// Counts of a kernel.
    KernelCounts = 21,
    /// Which kernel it is, and what it does with queries and outputs.
    KernelRule = 22,
    /// What a query consists of.
    Inputs = 23,
    /// What a kernel gives.
    Outputs = 24,
    /// Shift, scale and range of each feature.
    Features = 25,
    /// The metric of distances.
    Metric = 26,
    /// Centres of a kernel.
    KernelCentres = 27,
    /// Monomials of a kernel's polynomial.
    Terms = 28,
    /// From a kernel's basis to its values.
    KernelCoefficients = 29,
    /// What the variance of a kernel's values is computed of.
    Variance = 30,
    /// What a kernel's fit was measured to reach.
    KernelFit = 31,
    /// Tangent coefficients of each influence but a vertex's last.
    TangentCoefficients = 32,
    /// How far a skin's normals were measured to be from the true ones.
    NormalErrors = 33,
    /// Steps and box of each shape.
    Shapes = 34,
    /// Where the entries of each block of vertices start.
    ShapeBlocks = 35,
    /// Which vertices of a block a shape moves, and where its deltas start.
    ShapeEntries = 36,
    /// How far shapes move vertices.
    ShapeDeltas = 37,
    /// How shapes tilt the surface at vertices.
    ShapeSlopes = 38,
    /// How far shapes were measured to be from those that were baked.
    ShapeErrors = 39,
    /// Counts of a prior.
    PriorCounts = 40,
    /// Mean weights.
    PriorMean = 41,
    /// Factor of the precision of weights.
    PriorFactor = 42,
    /// Least and greatest weights.
    WeightBounds = 43,
    /// Pairs of shapes that mirror each other.
    Symmetry = 44,
    /// Pairs of shapes of which one alone is at work.
    CancelPairs = 45,
    /// How stiff pins are by default, and what a prior was measured to reach.
    PriorFit = 46,
    /// Which elements each layer of an object has, and which layer it shows itself on.
    Layers = 47,
    /// Where the weights of each vertex of an object end, and where it stands without them.
    Vertices = 48,
    /// By which control points vertices of an object stand, and how much each counts.
    VertexWeights = 49,
    /// Counts of an object.
    ViewsCounts = 50,
    /// The kernels that are an object's maps.
    Maps = 51,
    /// Triangles and quads between vertices.
    Elements = 52,
    /// Texture of each layer in each key view.
    ViewTextures = 53,
    /// Where key views have control points on the screen.
    References = 54,
    /// Which control points key views show.
    ViewMasks = 55,
    /// Size of each texture, and where its texels start.
    Textures = 56,
    /// Colours of textures.
    Texels = 57,
    /// How an object differs from the one as which it moves.
    Deformations = 58,
    /// What an object was measured to reach.
    ViewsFit = 59,
    /// Counts of a filter.
    FilterCounts = 60,
    /// By how much each coarse sample of a window counts for each fine one.
    FilterTaps = 61,
    /// Variance of each fine sample.
    FilterVariances = 62,
    /// How far a filter was measured to be from what it was trained on.
    FilterFit = 63,
    /// Counts of a record.
    #[cfg(feature = "record")]
    RecordCounts = 64,
    /// Marks by which training frames are known again.
    #[cfg(feature = "record")]
    FrameMarks = 65,
    /// Joints of linear blend skinning.
    #[cfg(feature = "record")]
    LbsJoints = 66,
    /// Weights of linear blend skinning.
    #[cfg(feature = "record")]
    LbsWeights = 67,
    /// Which element lies across each edge of an element.
    Neighbours = 68,
    /// Where vertices are in the textures of key views.
    VertexTexels = 69,
}

impl SectionKind {
    /// Every kind, by number.
    pub const ALL: [Self; 65 + 4 * cfg!(feature = "record") as usize] = [
        Self::Names,
        Self::Hierarchy,
        Self::InverseBinds,
        Self::RestPositions,
        Self::RestNormals,
        Self::RestTangents,
        Self::InfluenceIndices,
        Self::InfluenceWeights,
        Self::Keys,
        Self::C1,
        Self::C2,
        Self::RestBoxes,
        Self::PoseRanges,
        Self::Origins,
        Self::Groups,
        Self::Corrections,
        Self::EnvelopeCounts,
        Self::Certificate,
        Self::SkinCounts,
        Self::Ranges,
        Self::KernelCounts,
        Self::KernelRule,
        Self::Inputs,
        Self::Outputs,
        Self::Features,
        Self::Metric,
        Self::KernelCentres,
        Self::Terms,
        Self::KernelCoefficients,
        Self::Variance,
        Self::KernelFit,
        Self::TangentCoefficients,
        Self::NormalErrors,
        Self::Shapes,
        Self::ShapeBlocks,
        Self::ShapeEntries,
        Self::ShapeDeltas,
        Self::ShapeSlopes,
        Self::ShapeErrors,
        Self::PriorCounts,
        Self::PriorMean,
        Self::PriorFactor,
        Self::WeightBounds,
        Self::Symmetry,
        Self::CancelPairs,
        Self::PriorFit,
        Self::Layers,
        Self::Vertices,
        Self::VertexWeights,
        Self::ViewsCounts,
        Self::Maps,
        Self::Elements,
        Self::ViewTextures,
        Self::References,
        Self::ViewMasks,
        Self::Textures,
        Self::Texels,
        Self::Deformations,
        Self::ViewsFit,
        Self::FilterCounts,
        Self::FilterTaps,
        Self::FilterVariances,
        Self::FilterFit,
        #[cfg(feature = "record")]
        Self::RecordCounts,
        #[cfg(feature = "record")]
        Self::FrameMarks,
        #[cfg(feature = "record")]
        Self::LbsJoints,
        #[cfg(feature = "record")]
        Self::LbsWeights,
        Self::Neighbours,
        Self::VertexTexels,
    ];

    /// Returns its number in the file.
    pub const fn number(self) -> u16 {
        self as u16
    }

    /// Returns the kind of this number.
    pub fn from_number(number: u16) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.number() == number)
    }

    /// Returns its name, as FORMAT.md has it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Names => "names",
            Self::Hierarchy => "hierarchy",
            Self::InverseBinds => "inverse_binds",
            Self::RestPositions => "rest_positions",
            Self::RestNormals => "rest_normals",
            Self::RestTangents => "rest_tangents",
            Self::InfluenceIndices => "influence_indices",
            Self::InfluenceWeights => "influence_weights",
            Self::Keys => "keys",
            Self::C1 => "c1",
            Self::C2 => "c2",
            Self::RestBoxes => "rest_boxes",
            Self::PoseRanges => "pose_ranges",
            Self::Origins => "origins",
            Self::Groups => "groups",
            Self::Corrections => "corrections",
            Self::EnvelopeCounts => "envelope_counts",
            Self::Certificate => "certificate",
            Self::SkinCounts => "skin_counts",
            Self::Ranges => "ranges",
            Self::KernelCounts => "kernel_counts",
            Self::KernelRule => "kernel_rule",
            Self::Inputs => "inputs",
            Self::Outputs => "outputs",
            Self::Features => "features",
            Self::Metric => "metric",
            Self::KernelCentres => "kernel_centres",
            Self::Terms => "terms",
            Self::KernelCoefficients => "kernel_coefficients",
            Self::Variance => "variance",
            Self::KernelFit => "kernel_fit",
            Self::TangentCoefficients => "tangent_coefficients",
            Self::NormalErrors => "normal_errors",
            Self::Shapes => "shapes",
            Self::ShapeBlocks => "shape_blocks",
            Self::ShapeEntries => "shape_entries",
            Self::ShapeDeltas => "shape_deltas",
            Self::ShapeSlopes => "shape_slopes",
            Self::ShapeErrors => "shape_errors",
            Self::PriorCounts => "prior_counts",
            Self::PriorMean => "prior_mean",
            Self::PriorFactor => "prior_factor",
            Self::WeightBounds => "weight_bounds",
            Self::Symmetry => "symmetry",
            Self::CancelPairs => "cancel_pairs",
            Self::PriorFit => "prior_fit",
            Self::Layers => "layers",
            Self::Vertices => "vertices",
            Self::VertexWeights => "vertex_weights",
            Self::ViewsCounts => "views_counts",
            Self::Maps => "maps",
            Self::Elements => "elements",
            Self::ViewTextures => "view_textures",
            Self::References => "references",
            Self::ViewMasks => "view_masks",
            Self::Textures => "textures",
            Self::Texels => "texels",
            Self::Deformations => "deformations",
            Self::ViewsFit => "views_fit",
            Self::FilterCounts => "filter_counts",
            Self::FilterTaps => "filter_taps",
            Self::FilterVariances => "filter_variances",
            Self::FilterFit => "filter_fit",
            #[cfg(feature = "record")]
            Self::RecordCounts => "record_counts",
            #[cfg(feature = "record")]
            Self::FrameMarks => "frame_marks",
            #[cfg(feature = "record")]
            Self::LbsJoints => "lbs_joints",
            #[cfg(feature = "record")]
            Self::LbsWeights => "lbs_weights",
            Self::Neighbours => "neighbours",
            Self::VertexTexels => "vertex_texels",
        }
    }

    /// Returns the types that its elements may have; a file's row says which.
    pub const fn elements(self) -> &'static [Element] {
        match self {
            Self::Names | Self::Keys | Self::Groups | Self::Corrections => &[Element::Mixed],
            Self::KernelRule | Self::Inputs | Self::Outputs => &[Element::Mixed],
            Self::Symmetry | Self::Texels => &[Element::Mixed],
            Self::Vertices | Self::VertexWeights => &[Element::Mixed],
            Self::Hierarchy | Self::InfluenceIndices | Self::Terms => &[Element::U16],
            Self::CancelPairs | Self::Elements | Self::Neighbours => &[Element::U16],
            #[cfg(feature = "record")]
            Self::LbsJoints | Self::LbsWeights => &[Element::U16],
            Self::EnvelopeCounts | Self::SkinCounts | Self::Ranges => &[Element::U32],
            Self::KernelCounts | Self::ShapeBlocks | Self::ShapeEntries => &[Element::U32],
            Self::PriorCounts | Self::ViewsCounts | Self::FilterCounts => &[Element::U32],
            #[cfg(feature = "record")]
            Self::RecordCounts => &[Element::U32],
            Self::Layers => &[Element::U32],
            Self::Maps | Self::ViewTextures | Self::ViewMasks | Self::Textures => &[Element::U32],
            Self::TangentCoefficients => &[Element::F16],
            Self::ShapeDeltas | Self::ShapeSlopes => &[Element::F32, Element::F16, Element::I8],
            _ => &[Element::F32],
        }
    }

    /// Whether the elements of the kind of a number may have the type of a number; those of an unknown kind any.
    pub(crate) fn takes(kind: u16, element: u8) -> bool {
        // A bit a type, and none for a number that no kind has: what `elements` returns is ten times as large,
        // and firmware reads files as well.
        const LAST: SectionKind = SectionKind::ALL[SectionKind::ALL.len() - 1];
        const BITS: [u8; LAST.number() as usize + 1] = {
            let mut bits = [0; LAST.number() as usize + 1];
            let mut at = 0;
            while at < SectionKind::ALL.len() {
                let kind = SectionKind::ALL[at];
                let (number, elements) = (kind.number() as usize, kind.elements());
                let mut own = 0;
                while own < elements.len() {
                    bits[number] |= 1 << elements[own].number();
                    own += 1;
                }
                at += 1;
            }
            bits
        };
        let bits = BITS.get(usize::from(kind)).copied().unwrap_or_default();
        bits == 0 || u32::from(bits).checked_shr(element.into()).unwrap_or_default() & 1 == 1
    }
}
