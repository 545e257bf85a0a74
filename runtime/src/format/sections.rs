//! Kinds of sections: their names, numbers and element types.

use super::tables::Element;
use crate::named::named;

named! {
    /// A kind of section. A number never changes meaning. Each kind of part defines its own sections.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[repr(u16)]
    #[cfg_attr(not(feature = "internals"), non_exhaustive)]
    pub enum SectionKind {
        /// Names of the part and its components: joints, ranges of vertices, inputs and outputs.
        Names = 1, "names";
        /// Parent of each joint, the evaluation order, and each joint's rank in the order.
        Hierarchy = 2, "hierarchy";
        /// Inverse bind matrices.
        InverseBinds = 3, "inverse_binds";
        /// Rest positions.
        RestPositions = 4, "rest_positions";
        /// Rest normals.
        RestNormals = 5, "rest_normals";
        /// Rest tangents with handedness.
        RestTangents = 6, "rest_tangents";
        /// Palette index of each influence.
        InfluenceIndices = 7, "influence_indices";
        /// Weight of each influence.
        InfluenceWeights = 8, "influence_weights";
        /// Key predictors.
        Keys = 9, "keys";
        /// From gradients to palette.
        C1 = 10, "c1";
        /// From joints to palette.
        C2 = 11, "c2";
        /// Rest box of the vertices that each transform of the palette moves.
        RestBoxes = 12, "rest_boxes";
        /// Largest rotation of each joint in training, and its largest distance from its parent.
        PoseRanges = 13, "pose_ranges";
        /// Origin of each joint in the rest pose.
        Origins = 14, "origins";
        /// Groups of proxies with a shared kernel map.
        Groups = 15, "groups";
        /// Numbers of the kernel maps, in the order of the groups.
        Corrections = 16, "corrections";
        /// Counts of an envelope.
        EnvelopeCounts = 17, "envelope_counts";
        /// Measured accuracy of an envelope's fit.
        Certificate = 18, "certificate";
        /// Counts of a skin.
        SkinCounts = 19, "skin_counts";
        /// Ranges of vertices: the artist's separate meshes.
        Ranges = 20, "ranges";
        /// Counts of a kernel.
        KernelCounts = 21, "kernel_counts";
        /// Choice of kernel, and rules for queries and outputs.
        KernelRule = 22, "kernel_rule";
        /// Inputs of a query.
        Inputs = 23, "inputs";
        /// Outputs of a kernel.
        Outputs = 24, "outputs";
        /// Shift, scale and range of each feature.
        Features = 25, "features";
        /// Metric of the distances.
        Metric = 26, "metric";
        /// Centres of a kernel.
        KernelCentres = 27, "kernel_centres";
        /// Monomials of a kernel's polynomial.
        Terms = 28, "terms";
        /// Matrix from a kernel's basis to its values.
        KernelCoefficients = 29, "kernel_coefficients";
        /// Matrices for the variance of a kernel's values.
        Variance = 30, "variance";
        /// Measured accuracy of a kernel's fit.
        KernelFit = 31, "kernel_fit";
        /// Tangent coefficients of each influence except a vertex's last.
        TangentCoefficients = 32, "tangent_coefficients";
        /// Measured error of a skin's normals.
        NormalErrors = 33, "normal_errors";
        /// Quantisation steps and box of each shape.
        Shapes = 34, "shapes";
        /// Start of the entries of each block of vertices.
        ShapeBlocks = 35, "shape_blocks";
        /// Vertices of a block that a shape moves, and the start of their deltas.
        ShapeEntries = 36, "shape_entries";
        /// Displacements of vertices by shapes.
        ShapeDeltas = 37, "shape_deltas";
        /// Tilt of the surface at vertices by shapes.
        ShapeSlopes = 38, "shape_slopes";
        /// Measured error of shapes against the baked originals.
        ShapeErrors = 39, "shape_errors";
        /// Counts of a prior.
        PriorCounts = 40, "prior_counts";
        /// Mean weights.
        PriorMean = 41, "prior_mean";
        /// Factor of the precision of weights.
        PriorFactor = 42, "prior_factor";
        /// Least and greatest weights.
        WeightBounds = 43, "weight_bounds";
        /// Pairs of shapes that mirror each other.
        Symmetry = 44, "symmetry";
        /// Pairs of mutually exclusive shapes.
        CancelPairs = 45, "cancel_pairs";
        /// Default stiffness of pins, and measured accuracy of a prior.
        PriorFit = 46, "prior_fit";
        /// Elements of each layer of an object, and the layer that clips it.
        Layers = 47, "layers";
        /// End of the weights of each vertex of an object, and its place without weights.
        Vertices = 48, "vertices";
        /// Control points of an object's vertices, with their weights.
        VertexWeights = 49, "vertex_weights";
        /// Counts of an object.
        ViewsCounts = 50, "views_counts";
        /// Kernels that are an object's maps.
        Maps = 51, "maps";
        /// Triangles and quads between vertices.
        Elements = 52, "elements";
        /// Texture of each layer in each key view.
        ViewTextures = 53, "view_textures";
        /// Places of control points on the screen in key views.
        References = 54, "references";
        /// Control points that are visible in key views.
        ViewMasks = 55, "view_masks";
        /// Size of each texture, and the start of its texels.
        Textures = 56, "textures";
        /// Colours of textures.
        Texels = 57, "texels";
        /// Difference between an object and its prototype.
        Deformations = 58, "deformations";
        /// Measured accuracy of an object.
        ViewsFit = 59, "views_fit";
        /// Counts of a filter.
        FilterCounts = 60, "filter_counts";
        /// Weight of each coarse sample of a window for each fine sample.
        FilterTaps = 61, "filter_taps";
        /// Variance of each fine sample.
        FilterVariances = 62, "filter_variances";
        /// Measured error of a filter on its training data.
        FilterFit = 63, "filter_fit";
        /// Counts of a record.
        RecordCounts = 64, "record_counts";
        /// Marks that identify training frames.
        FrameMarks = 65, "frame_marks";
        /// Joints of linear blend skinning.
        LbsJoints = 66, "lbs_joints";
        /// Weights of linear blend skinning.
        LbsWeights = 67, "lbs_weights";
        /// Element across each edge of an element.
        Neighbours = 68, "neighbours";
        /// Places of vertices in the textures of key views.
        VertexTexels = 69, "vertex_texels";
        /// Largest strain of each joint in training.
        StretchRanges = 70, "stretch_ranges";
        /// Scale and shear of keys that follow the strain of their joints.
        KeyStretches = 71, "key_stretches";
        /// Least and greatest value of each curve in training.
        CurveRanges = 72, "curve_ranges";
        /// Centre and spread of the vertices that each proxy moves, in the rest pose.
        HelperPlaces = 73, "helper_places";
    }
    /// Every kind, by number.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) ALL;
    /// Returns its name, as in FORMAT.md.
    pub name;
}

impl SectionKind {
    /// Returns its number in the file.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) const fn number(self) -> u16 {
        self as u16
    }

    /// Returns the kind with this number.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn from_number(number: u16) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.number() == number)
    }

    /// Returns the allowed types of its elements; a file's row chooses one.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) const fn elements(self) -> &'static [Element] {
        match self {
            Self::Names | Self::Keys | Self::Groups | Self::Corrections => &[Element::Mixed],
            Self::KernelRule | Self::Inputs | Self::Outputs => &[Element::Mixed],
            Self::Symmetry | Self::Texels => &[Element::Mixed],
            Self::Vertices | Self::VertexWeights => &[Element::Mixed],
            Self::Hierarchy | Self::InfluenceIndices | Self::Terms => &[Element::U16],
            Self::CancelPairs | Self::Elements | Self::Neighbours => &[Element::U16],
            Self::LbsJoints | Self::LbsWeights => &[Element::U16],
            Self::EnvelopeCounts | Self::SkinCounts | Self::Ranges => &[Element::U32],
            Self::KernelCounts | Self::ShapeBlocks | Self::ShapeEntries => &[Element::U32],
            Self::PriorCounts | Self::ViewsCounts | Self::FilterCounts => &[Element::U32],
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
