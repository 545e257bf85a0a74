//! Kinds of sections: their names, numbers and element types.

use super::tables::Element;

/// A kind of section. A number never changes meaning. Each kind of part defines its own sections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum SectionKind {
    /// Names of the part and its components: joints, ranges of vertices, inputs and outputs.
    Names = 1,
    /// Parent of each joint, the evaluation order, and each joint's rank in the order.
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
    /// From gradients to palette.
    C1 = 10,
    /// From joints to palette.
    C2 = 11,
    /// Rest box of the vertices that each transform of the palette moves.
    RestBoxes = 12,
    /// Largest rotation of each joint in training, and its largest distance from its parent.
    PoseRanges = 13,
    /// Origin of each joint in the rest pose.
    Origins = 14,
    /// Groups of proxies with a shared kernel map.
    Groups = 15,
    /// Numbers of the kernel maps, in the order of the groups.
    Corrections = 16,
    /// Counts of an envelope.
    EnvelopeCounts = 17,
    /// Measured accuracy of an envelope's fit.
    Certificate = 18,
    /// Counts of a skin.
    SkinCounts = 19,
    /// Ranges of vertices: the artist's separate meshes.
    Ranges = 20,
    /// Counts of a kernel.
    KernelCounts = 21,
    /// Choice of kernel, and rules for queries and outputs.
    KernelRule = 22,
    /// Inputs of a query.
    Inputs = 23,
    /// Outputs of a kernel.
    Outputs = 24,
    /// Shift, scale and range of each feature.
    Features = 25,
    /// Metric of the distances.
    Metric = 26,
    /// Centres of a kernel.
    KernelCentres = 27,
    /// Monomials of a kernel's polynomial.
    Terms = 28,
    /// Matrix from a kernel's basis to its values.
    KernelCoefficients = 29,
    /// Matrices for the variance of a kernel's values.
    Variance = 30,
    /// Measured accuracy of a kernel's fit.
    KernelFit = 31,
    /// Tangent coefficients of each influence except a vertex's last.
    TangentCoefficients = 32,
    /// Measured error of a skin's normals.
    NormalErrors = 33,
    /// Quantisation steps and box of each shape.
    Shapes = 34,
    /// Start of the entries of each block of vertices.
    ShapeBlocks = 35,
    /// Vertices of a block that a shape moves, and the start of their deltas.
    ShapeEntries = 36,
    /// Displacements of vertices by shapes.
    ShapeDeltas = 37,
    /// Tilt of the surface at vertices by shapes.
    ShapeSlopes = 38,
    /// Measured error of shapes against the baked originals.
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
    /// Pairs of mutually exclusive shapes.
    CancelPairs = 45,
    /// Default stiffness of pins, and measured accuracy of a prior.
    PriorFit = 46,
    /// Elements of each layer of an object, and the layer that clips it.
    Layers = 47,
    /// End of the weights of each vertex of an object, and its place without weights.
    Vertices = 48,
    /// Control points of an object's vertices, with their weights.
    VertexWeights = 49,
    /// Counts of an object.
    ViewsCounts = 50,
    /// Kernels that are an object's maps.
    Maps = 51,
    /// Triangles and quads between vertices.
    Elements = 52,
    /// Texture of each layer in each key view.
    ViewTextures = 53,
    /// Places of control points on the screen in key views.
    References = 54,
    /// Control points that are visible in key views.
    ViewMasks = 55,
    /// Size of each texture, and the start of its texels.
    Textures = 56,
    /// Colours of textures.
    Texels = 57,
    /// Difference between an object and its prototype.
    Deformations = 58,
    /// Measured accuracy of an object.
    ViewsFit = 59,
    /// Counts of a filter.
    FilterCounts = 60,
    /// Weight of each coarse sample of a window for each fine sample.
    FilterTaps = 61,
    /// Variance of each fine sample.
    FilterVariances = 62,
    /// Measured error of a filter on its training data.
    FilterFit = 63,
    /// Counts of a record.
    #[cfg(feature = "record")]
    RecordCounts = 64,
    /// Marks that identify training frames.
    #[cfg(feature = "record")]
    FrameMarks = 65,
    /// Joints of linear blend skinning.
    #[cfg(feature = "record")]
    LbsJoints = 66,
    /// Weights of linear blend skinning.
    #[cfg(feature = "record")]
    LbsWeights = 67,
    /// Element across each edge of an element.
    Neighbours = 68,
    /// Places of vertices in the textures of key views.
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

    /// Returns the kind with this number.
    pub fn from_number(number: u16) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.number() == number)
    }

    /// Returns its name, as in FORMAT.md.
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

    /// Returns the allowed types of its elements; a file's row chooses one.
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

    /// Whether elements of kind number `kind` may have type number `element`. An unknown kind
    /// accepts any type.
    pub(crate) fn takes(kind: u16, element: u8) -> bool {
        // One bit per type, and no bits for an unassigned number. The slices of `elements` would be
        // ten times as large, and firmware reads files too.
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
