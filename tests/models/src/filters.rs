//! Filters as plain lists, whose fields may be invalid.

use crate::bytes::{floats, names, words};
use crate::message::head;
use crate::pieces::{Content, Pieces};
use sinew_runtime::filter::FILTER_SECTIONS;
use sinew_runtime::format::{PartKind, PartRow, SectionKind};

/// A filter as plain lists.
#[derive(Clone)]
pub struct FilterContent {
    /// Name of the part.
    pub name: String,
    /// Factor F.
    pub factor: u32,
    /// Number of taps N.
    pub tap_len: u32,
    /// N F N taps, by place, then phase.
    pub taps: Vec<f32>,
    /// N F variances, if the file has them.
    pub variances: Option<Vec<f32>>,
    /// Step, RMS error of left-out samples, RMS error of linear interpolation.
    pub fit: [f32; 3],
}

impl FilterContent {
    /// Makes a filter of F phases and N taps, all different, with variances.
    pub fn sample(factor: u32, tap_len: u32) -> Self {
        let rows = factor * tap_len;
        // Quarters: products with whole numbers are exact.
        let tap = |at: u32| 0.25 * ((7 * at + 3) % 11) as f32 - 1.0;
        Self {
            name: "filter".to_owned(),
            factor,
            tap_len,
            taps: (0..rows * tap_len).map(tap).collect(),
            variances: Some((0..rows).map(|row| 0.125 * row as f32).collect()),
            fit: [0.01, 0.125, 0.25],
        }
    }

    /// Makes a filter for a sensor: each sample becomes four samples, spread evenly about it, on
    /// the polynomial through five.
    pub fn sensor() -> Self {
        let (factor, tap_len) = (4, 5);
        let weight = |place: u32, phase: u32, tap: u32| {
            let x = f64::from(place) + (f64::from(phase) + 0.5) / f64::from(factor) - 0.5;
            let others = (0..tap_len).filter(|other| *other != tap).map(f64::from);
            others.map(|other| (x - other) / (f64::from(tap) - other)).product::<f64>() as f32
        };
        let rows = (0..tap_len).flat_map(|place| (0..factor).map(move |phase| (place, phase)));
        let taps = rows.flat_map(|(place, phase)| (0..tap_len).map(move |tap| (place, phase, tap)));
        Self {
            name: "sensor".to_owned(),
            factor,
            tap_len,
            taps: taps.map(|(place, phase, tap)| weight(place, phase, tap)).collect(),
            variances: None,
            fit: [0.01, 0.0, 0.0],
        }
    }

    /// Writes the sections.
    ///
    /// # Panics
    /// If the order of sections differs from FORMAT.md.
    fn sections(&self) -> Vec<(SectionKind, Vec<u8>)> {
        let variances = self.variances.as_ref();
        let written = [
            Some((SectionKind::FilterCounts, words(&[self.factor, self.tap_len]))),
            Some((SectionKind::Names, names(&self.name, &[]))),
            Some((SectionKind::FilterTaps, floats(&self.taps))),
            variances.map(|variances| (SectionKind::FilterVariances, floats(variances))),
            Some((SectionKind::FilterFit, floats(&self.fit))),
        ];
        let written: Vec<_> = written.into_iter().flatten().collect();
        let mut order = FILTER_SECTIONS.iter();
        assert!(written.iter().all(|(kind, _)| order.any(|own| own == kind)));
        written
    }
}

impl Pieces {
    /// Makes a file of one filter.
    ///
    /// # Panics
    /// If the order of sections differs from FORMAT.md.
    pub fn filter(content: &FilterContent) -> Self {
        let mut pieces = Self { head: head::SOUND, parts: Vec::new(), sections: Vec::new() };
        pieces.add_filter(content);
        pieces
    }

    /// Appends a filter.
    ///
    /// # Panics
    /// If the order of sections differs from FORMAT.md.
    pub fn add_filter(&mut self, content: &FilterContent) {
        let part = self.parts.len() as u16;
        self.parts.push(PartRow { kind: PartKind::Filter.number(), flags: 1 });
        let own = content.sections().into_iter();
        self.sections.extend(own.map(|(kind, bytes)| Content::new(kind, part, bytes)));
    }
}
