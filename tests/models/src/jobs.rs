//! Arguments of jobs: shared floats, and rest meshes with optional attributes.

use sinew_runtime::SkinJob;
use std::cell::Cell;

/// Lends floats to several outputs of a job.
pub fn cells(floats: &mut [f32]) -> &[Cell<f32>] {
    Cell::from_mut(floats).as_slice_of_cells()
}

/// Rest mesh of a caller; the file's arrays replace missing arrays.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rest<'a> {
    /// V positions.
    pub positions: Option<&'a [[f32; 3]]>,
    /// V normals.
    pub normals: Option<&'a [[f32; 3]]>,
    /// V tangents.
    pub tangents: Option<&'a [[f32; 4]]>,
}

impl<'a> Rest<'a> {
    /// Gives the rest mesh to a job.
    pub fn of<'j>(self, mut job: SkinJob<'j>) -> SkinJob<'j>
    where
        'a: 'j,
    {
        if let Some(positions) = self.positions {
            job = job.rest_positions(positions);
        }
        if let Some(normals) = self.normals {
            job = job.rest_normals(normals);
        }
        match self.tangents {
            Some(tangents) => job.rest_tangents(tangents),
            None => job,
        }
    }
}
