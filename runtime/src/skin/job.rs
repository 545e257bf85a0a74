//! Job of the stage `skin`: the arguments and their checks.

use super::output::{Output, Outputs, check_range};
use super::view::Skin;
use crate::error::{Argument, CallError, CallErrorKind};
use crate::linear::Matrix3x4;
use core::ops::Range;

/// Rest mesh of the caller: another face or body of the same topology. The file's arrays replace missing arrays.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rest<'a> {
    /// V positions.
    pub positions: Option<&'a [[f32; 3]]>,
    /// V normals of length 1.
    pub normals: Option<&'a [[f32; 3]]>,
    /// V tangents of length 1, each with its handedness.
    pub tangents: Option<&'a [[f32; 4]]>,
}

/// Job that skins a range of vertices.
///
/// Each vertex blends its K transforms in the file's order, `sum w_k T_k`. The blended transform m moves the position x
/// by columns, `((m_0 x + m_1 y) + m_2 z) + m_3`. Without an envelope the mesh stays at rest, and directions get
/// length 1.
///
/// The job leaves floats between attributes alone. If attributes overlap, the later field of this job wins.
#[derive(Clone, Debug)]
pub struct SkinJob<'a> {
    /// Skin to evaluate.
    pub skin: Skin<'a>,
    /// [`Skin::palette_len`] transforms, rest to posed.
    pub palette: &'a [Matrix3x4],
    /// Range of vertices: of the remap if there is one, else of the skin. Jobs of different ranges can run at the same
    /// time.
    pub vertices: Range<usize>,
    /// Maps each engine vertex to the skin vertex that it copies. Vertices that were split along seams or reordered
    /// then need no second pass.
    pub remap: Option<&'a [u32]>,
    /// Rest mesh of the caller, in the order of the skin's vertices.
    pub rest: Rest<'a>,
    /// Output of positions: 3 floats, in model space.
    pub positions: Option<Output<'a>>,
    /// Output of normals: 3 floats of length 1, outward even if the palette mirrors.
    ///
    /// A skin with tangent coefficients uses the coefficients. If these leave no direction, the transform of the
    /// strongest influence turns the rest normal. A skin without tangent coefficients uses the cofactors of the blended
    /// 3x3. If no direction is left, the result is the rest normal, which may be 0.
    pub normals: Option<Output<'a>>,
    /// Output of tangents: 3 floats of length 1, then the handedness of the rest pose.
    ///
    /// The tangent follows the tangent coefficients, or without them the blended 3x3. If no direction is left, the
    /// result is the rest tangent.
    pub tangents: Option<Output<'a>>,
}

impl SkinJob<'_> {
    /// Checks every argument. The errors are those of [`SkinJob::run`].
    pub(super) fn check(&self) -> Result<(), CallError> {
        let vertex_len = self.skin.vertex_len();
        let outputs = Outputs::new(self.positions, self.normals, self.tangents)?;
        Argument::Palette.check_len(self.skin.palette_len(), self.palette.len())?;
        let Rest { positions, normals, tangents } = self.rest;
        for (argument, found) in [
            (Argument::RestPositions, positions.map(<[_]>::len)),
            (Argument::RestNormals, normals.map(<[_]>::len)),
            (Argument::RestTangents, tangents.map(<[_]>::len)),
        ] {
            argument.check_len(vertex_len, found.unwrap_or(vertex_len))?;
        }
        check_range(&self.vertices, self.remap.map_or(vertex_len, <[_]>::len))?;
        let Range { start, end } = self.vertices;
        let remap = self.remap.and_then(|remap| remap.get(start..end)).unwrap_or_default();
        if let Some(at) = remap.iter().position(|vertex| *vertex as usize >= vertex_len) {
            let found = remap.get(at).map_or(0, |vertex| *vertex as usize);
            let error = CallError::new(CallErrorKind::OutOfRange, Argument::Remap).at(start + at);
            return Err(error.values(vertex_len.saturating_sub(1), found));
        }
        if self.tangents.is_some() && tangents.is_none() && !self.skin.has_tangents() {
            return Err(CallError::new(CallErrorKind::NoAttribute, Argument::Tangents));
        }
        outputs.check(end - start)
    }
}
