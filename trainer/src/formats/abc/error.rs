//! What can be wrong with an Alembic archive.

/// An Alembic archive that cannot be read, or is not of one mesh.
#[derive(Debug, thiserror::Error)]
pub enum AlembicError {
    /// The archive is in a container that is not read.
    #[error(
        "is Alembic in an HDF5 container, which is not read; export it again with Ogawa as its data format"
    )]
    Hdf5,
    /// The file does not begin as an archive that is read.
    #[error("is no Alembic archive of Ogawa's version 1: {reason}; export it as .abc again")]
    NotAlembic {
        /// What is different.
        reason: String,
    },
    /// What wrote the file did not come to its end.
    #[error("was not closed by what wrote it; export it again, to the end")]
    Unfinished,
    /// The file says of itself what cannot be.
    #[error("is damaged: {what}; export it again")]
    Damaged {
        /// What cannot be.
        what: String,
    },
    /// The file names more than it can be meant to hold.
    #[error(
        "unfolds to more than {most} bytes, the most for a file of its size, by naming the same bytes again and \
         again; export the frames that are wanted alone"
    )]
    TooLarge {
        /// The most.
        most: usize,
    },
    /// There is no mesh.
    #[error("holds no polygon mesh: export the character's mesh, as polygons")]
    NoMesh,
    /// A mesh has no positions.
    #[error("mesh {mesh} has no vertex; leave it out, or export it with its points")]
    NoVertices {
        /// The mesh.
        mesh: String,
    },
    /// A mesh has other vertices in one frame than in the first.
    #[error(
        "mesh {mesh} has {found} vertices in frame {frame}, expected {expected} as in the first; export it \
         without what changes its vertices over time"
    )]
    OtherVertices {
        /// The mesh.
        mesh: String,
        /// The frame.
        frame: usize,
        /// Vertices in it.
        found: usize,
        /// Vertices in the first.
        expected: usize,
    },
    /// A mesh has other faces in one frame than in the first.
    #[error(
        "mesh {mesh} has other faces in frame {frame} than in the first; export it without what changes its \
         faces over time"
    )]
    OtherFaces {
        /// The mesh.
        mesh: String,
        /// The frame.
        frame: usize,
    },
    /// Two things are sampled differently often.
    #[error(
        "{object} has {found} samples, expected 1 or {expected} as others have; export all over the same frames \
         and at one rate"
    )]
    OtherSamples {
        /// The mesh or transform.
        object: String,
        /// Its samples.
        found: usize,
        /// The most that there are of one.
        expected: usize,
    },
}

/// Says what cannot be.
pub(super) fn damaged(what: impl Into<String>) -> AlembicError {
    AlembicError::Damaged { what: what.into() }
}
