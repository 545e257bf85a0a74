//! How a file holds envelopes and the skins that follow them.

mod envelope;
mod file;
mod groups;
mod record;
mod shapes;
mod skin;
