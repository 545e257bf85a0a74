//! The envelope's commands, one a file. They have no noun in front of their names.

mod check;
mod demo;
mod eval;
mod export;
mod levels;
mod poses;
mod report;
mod table;
mod train;

commands! {
    Demo(demo::Demo),
    Poses(poses::PosesArgs),
    Check(check::CheckArgs),
    Train(train::Train),
    Eval(eval::Eval),
    Report(report::ReportArgs),
    Export(export::ExportArgs),
    ExportDemo(demo::ExportDemo),
}
