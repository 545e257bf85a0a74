//! Builds images.

use super::targets::{M4F, Target};
use std::path::{Path, PathBuf};
use std::process::Command;

/// What an image is for; each is a program of `tests/firmware/src/bin`.
#[derive(Clone, Copy)]
pub(super) enum Image {
    Bits,
    Minimal,
    Servo,
    Cost,
    CostServo,
    Proof,
    Bare,
    SizeRotational,
    SizeAny,
    SizeAll,
    SizeServo,
    ControlPanic,
    ControlAlloc,
}

impl Image {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Bits => "bits",
            Self::Minimal => "minimal",
            Self::Servo => "servo",
            Self::Cost => "cost",
            Self::CostServo => "cost_servo",
            Self::Proof => "proof",
            Self::Bare => "bare",
            Self::SizeRotational => "size_rotational",
            Self::SizeAny => "size_any",
            Self::SizeAll => "size_all",
            Self::SizeServo => "size_servo",
            Self::ControlPanic => "control_panic",
            Self::ControlAlloc => "control_alloc",
        }
    }
}

/// How an image is optimised.
#[derive(Clone, Copy)]
pub(super) enum Profile {
    /// opt-level 3.
    Release,
    /// opt-level s.
    Small,
}

impl Profile {
    pub(super) const ALL: [Self; 2] = [Self::Release, Self::Small];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Release => "release",
            Self::Small => "small",
        }
    }
}

/// Builds an image and returns where it lies.
pub(super) fn build(
    folder: &Path,
    target: Target,
    profile: Profile,
    image: Image,
) -> Result<PathBuf, String> {
    crate::call::run(&mut command(folder, target, profile, image))?;
    let name = match target.triple {
        "wasm32-unknown-unknown" => format!("{}.wasm", image.name()),
        _ => image.name().to_owned(),
    };
    Ok(target_folder(folder, target).join(target.triple).join(profile.name()).join(name))
}

/// Sees the image fail to link that has a panic, and for that reason.
pub(super) fn control_fails(folder: &Path, target: Target, profile: Profile) -> Result<(), String> {
    let output = command(folder, target, profile, Image::ControlPanic)
        .output()
        .map_err(|error| format!("cargo: {error}"))?;
    let errors = String::from_utf8_lossy(&output.stderr);
    if output.status.success() {
        return Err(format!("an image that can panic links ({})", profile.name()));
    }
    if errors.contains("undefined symbol: a_panic_is_reachable") {
        Ok(())
    } else {
        Err(format!("an image that can panic fails for another reason:\n{errors}"))
    }
}

/// Checks the format of the images, and lints them for the one target that has all of them.
pub(super) fn lint(folder: &Path) -> Result<(), String> {
    let fmt = ["fmt", "--manifest-path", MANIFEST, "--check"];
    crate::call::run(cargo(folder, M4F).args(fmt))?;
    let mut command = cargo(folder, M4F);
    command.args(["clippy", "--quiet", "--locked", "--manifest-path", MANIFEST]);
    command.args(["--bins", "--features", "control,cortex-m,kernel"]).args(triple(M4F));
    crate::call::run(command.args(["--", "-D", "warnings"]))
}

const MANIFEST: &str = "tests/firmware/Cargo.toml";

fn command(folder: &Path, target: Target, profile: Profile, image: Image) -> Command {
    let mut command = cargo(folder, target);
    command.args(["build", "--quiet", "--locked", "--manifest-path", MANIFEST]);
    command.args(["--bin", image.name(), "--profile", profile.name()]).args(triple(target));
    match image {
        Image::Cost => command.args(["--features", "cortex-m"]),
        Image::CostServo => command.args(["--features", "cortex-m,kernel"]),
        Image::Bits | Image::Proof | Image::Servo | Image::SizeServo => {
            command.args(["--features", "kernel"])
        }
        Image::ControlPanic | Image::ControlAlloc => command.args(["--features", "control"]),
        _ => &mut command,
    };
    command
}

fn triple(target: Target) -> Vec<&'static str> {
    if target.triple.is_empty() { Vec::new() } else { vec!["--target", target.triple] }
}

fn cargo(folder: &Path, target: Target) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.env("SINEW_MODELS", folder.join("models"));
    command.env("CARGO_TARGET_DIR", target_folder(folder, target));
    command.env("RUSTFLAGS", target.flags);
    command
}

/// Gives builds with flags of their own a folder of their own, so that neither undoes the other.
fn target_folder(folder: &Path, target: Target) -> PathBuf {
    folder.join(if target.flags.is_empty() { "plain" } else { "flags" })
}
