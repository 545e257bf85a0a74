//! The commands of views: `sinew views ...`.

mod eval;
mod export;
mod frames;
mod input;
mod render;
mod train;

commands! {
    Demo(train::Demo),
    Train(train::Train),
    Eval(eval::Eval),
    Render(render::Render),
    Animate(frames::Animate),
    Drive(frames::Drive),
    Transfer(train::Transfer),
    Pin(render::PinPoints),
    Report(eval::ReportArgs),
    Export(export::Export),
}
