//! The parts of a file, envelopes first; its bytes are put together in `bake/container.rs`.

use crate::bake::{BakeError, bake};
use crate::envelope::model::FileModel;

impl FileModel {
    /// Bakes a file, the envelopes first, the records last, and loads it once, so that what is returned is known to
    /// load.
    ///
    /// Weights are divided by their sum, then rounded; all else is rounded as it is.
    ///
    /// # Errors
    /// - [`BakeError::Length`]: arrays do not fit each other.
    /// - [`BakeError::Size`]: an index or a size does not fit the file.
    /// - [`BakeError::Hierarchy`]: joints do not form one tree.
    /// - [`BakeError::RestFrame`]: a rest frame is singular.
    /// - [`BakeError::Weights`]: a vertex has no positive sum of weights.
    /// - [`BakeError::Covariance`]: a prior's covariance has no inverse.
    /// - [`BakeError::NoEnvelope`]: a skin follows an envelope that is not there.
    /// - [`BakeError::Refused`]: anything else that the runtime would refuse, as a number that is not
    ///   finite.
    pub fn bake(&self) -> Result<Vec<u8>, BakeError> {
        let mut parts = Vec::new();
        for envelope in &self.envelopes {
            parts.push(envelope.part()?);
        }
        let found = self.envelopes.len();
        for (skin, model) in self.skins.iter().enumerate() {
            let followed = |envelope| {
                let missing = BakeError::NoEnvelope { skin, envelope, found };
                self.envelopes.get(envelope).ok_or(missing)
            };
            parts.push(model.part(model.envelope.map(followed).transpose()?)?);
        }
        for prior in &self.priors {
            parts.push(prior.part(found + prior.skin)?);
        }
        for record in &self.records {
            parts.push(record.part()?);
        }
        bake(self.space, &parts)
    }
}
