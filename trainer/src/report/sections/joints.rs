//! Errors by joint.

use super::series::{legend, length, names};
use crate::page::chart::bars;
use crate::page::html::{grouped, paragraph, table, text};
use crate::report::comparison::Comparison;
use crate::report::joints::by_joint;

/// A row for each joint: vertices, errors, the model's worst frame, bars.
pub(super) fn errors(comparison: &Comparison<'_>) -> String {
    let joints = by_joint(comparison);
    let series = comparison.series();
    let most = joints.iter().flat_map(|joint| &joint.rms_percent).copied().fold(0.0, f64::max);
    let mut head = vec!["joint".to_owned(), "vertices".to_owned()];
    head.extend(names(comparison).iter().map(|name| format!("{name}, %")));
    head.extend(["worst frame", "there, %", ""].map(str::to_owned));
    let row = |joint: &crate::report::joints::JointErrors| {
        let name = &comparison.source.examples.skeleton.names[joint.joint];
        let mut row = vec![text(name), grouped(joint.vertices)];
        row.extend(joint.rms_percent.iter().map(|rms| length(comparison, *rms)));
        row.extend([
            comparison.source.number(joint.worst.0).to_string(),
            length(comparison, joint.worst.1),
        ]);
        let values = series.iter().zip(&joint.rms_percent);
        let values: Vec<_> = values.map(|(series, rms)| (series.class, *rms)).collect();
        row.push(bars(&values, most));
        row
    };
    let rows: Vec<_> = joints.iter().map(row).collect();
    paragraph(
        "RMS over the measured frames. Each vertex counts for the joint that LBS lets it follow most; \
         the worst frame is the model's on those vertices.",
    ) + &legend(comparison)
        + &table(&head, &rows)
}
