//! Builds images.

use super::targets::{M4F, TARGETS, Target};
use std::path::{Path, PathBuf};
use std::process::Command;

/// An image: a program of `tests/firmware/src/bin`.
#[derive(Clone, Copy)]
pub(super) enum Image {
    Bits,
    Servo,
    Cost,
    CostServo,
    CostNormals,
    Proof,
    Bare,
    SizeRotational,
    SizeAny,
    SizeAll,
    SizeServo,
    Sensor,
    SizeSensor,
    SizeNormals,
    SizeViews,
    SizeShapes,
    ControlPanic,
    ControlAlloc,
}

impl Image {
    /// Images of the runtime without its features.
    const ENVELOPES: &[Self] = &[Self::Bare, Self::SizeRotational, Self::SizeAny, Self::SizeAll];
    /// Images of the part filter.
    const FILTER: &[Self] = &[Self::Sensor, Self::SizeSensor];
    /// Images of the part kernel.
    const KERNEL: &[Self] = &[Self::Servo, Self::SizeServo];

    fn features(self) -> Option<&'static str> {
        match self {
            Self::Cost => Some("cortex-m,internals,normals"),
            Self::CostServo => Some("cortex-m,internals,kernel,normals"),
            Self::CostNormals => Some("cortex-m,internals,normals"),
            Self::Bits => {
                Some("curves,filter,internals,kernel,normals,prior,shapes,stretch,trs,views")
            }
            Self::Proof => Some("curves,filter,internals,kernel,normals,prior,shapes,stretch,trs"),
            Self::Servo | Self::SizeServo => Some("kernel"),
            Self::Sensor | Self::SizeSensor => Some("filter"),
            Self::SizeNormals => Some("normals"),
            Self::SizeViews => Some("views"),
            Self::SizeShapes => Some("shapes"),
            Self::ControlPanic | Self::ControlAlloc => Some("control"),
            Self::Bare | Self::SizeRotational | Self::SizeAny | Self::SizeAll => None,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Bits => "bits",
            Self::Servo => "servo",
            Self::Cost => "cost",
            Self::CostServo => "cost_servo",
            Self::CostNormals => "cost_normals",
            Self::Proof => "proof",
            Self::Bare => "bare",
            Self::SizeRotational => "size_rotational",
            Self::SizeAny => "size_any",
            Self::SizeAll => "size_all",
            Self::SizeServo => "size_servo",
            Self::Sensor => "sensor",
            Self::SizeSensor => "size_sensor",
            Self::SizeNormals => "size_normals",
            Self::SizeViews => "size_views",
            Self::SizeShapes => "size_shapes",
            Self::ControlPanic => "control_panic",
            Self::ControlAlloc => "control_alloc",
        }
    }
}

/// Optimisation of an image.
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

/// Builds the image that prints hashes of every stage, for each target.
pub(super) fn bits(folder: &Path, targets: &[Target]) -> Result<(), String> {
    let is_here = |target: &&Target| target.triple.is_empty();
    for target in targets.iter().filter(is_here) {
        build(folder, &[*target], Profile::Release, &[Image::Bits])?;
    }
    let others: Vec<Target> = targets.iter().filter(|target| !is_here(target)).copied().collect();
    build(folder, &others, Profile::Release, &[Image::Bits])
}

/// Builds the other images: for the proof, sizes, costs and the README.
pub(super) fn others(folder: &Path) -> Result<(), String> {
    let bare: Vec<Target> = TARGETS.into_iter().filter(|target| target.bare).collect();
    for profile in Profile::ALL {
        build(folder, &bare, profile, &[Image::Proof])?;
        let own = [
            Image::ENVELOPES,
            Image::KERNEL,
            Image::FILTER,
            &[Image::SizeNormals],
            &[Image::SizeViews],
            &[Image::SizeShapes],
            &[Image::Cost],
            &[Image::CostServo],
            &[Image::CostNormals],
        ];
        for images in own {
            build(folder, &[M4F], profile, images)?;
        }
    }
    build(folder, &[M4F], Profile::Release, &[Image::ControlAlloc])
}

/// Builds images that share features, for targets that share flags, in one run of Cargo.
fn build(
    folder: &Path,
    targets: &[Target],
    profile: Profile,
    images: &[Image],
) -> Result<(), String> {
    crate::call::run(&mut command(folder, targets, profile, images))
}

/// Returns the path of a built image.
pub(super) fn path(folder: &Path, target: Target, profile: Profile, image: Image) -> PathBuf {
    let name = match target.triple {
        "wasm32-unknown-unknown" => format!("{}.wasm", image.name()),
        _ => image.name().to_owned(),
    };
    target_folder(folder, target).join(target.triple).join(profile.name()).join(name)
}

/// Checks that the image with a panic fails to link, because of the panic.
pub(super) fn control_fails(folder: &Path, target: Target, profile: Profile) -> Result<(), String> {
    let output = command(folder, &[target], profile, &[Image::ControlPanic])
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

/// Checks the format of the images, and lints them for the only target that has all images.
pub(super) fn lint(folder: &Path) -> Result<(), String> {
    let fmt = ["fmt", "--manifest-path", MANIFEST, "--check"];
    crate::call::run(cargo(folder, M4F).args(fmt))?;
    let mut command = cargo(folder, M4F);
    command.args(["clippy", "--quiet", "--locked", "--manifest-path", MANIFEST]);
    command
        .args([
            "--bins",
            "--features",
            "control,cortex-m,curves,filter,internals,kernel,normals,prior,shapes,stretch,trs,views",
        ])
        .args(triple(M4F));
    crate::call::run(command.args(["--", "-D", "warnings"]))
}

/// Builds the program of `runtime/examples/firmware` as its reader does, and returns its path.
pub(super) fn example(folder: &Path) -> Result<PathBuf, String> {
    let target = folder.join("example");
    let mut command = cargo(folder, M4F);
    command.current_dir("runtime/examples/firmware").env_remove("RUSTFLAGS");
    command.env("CARGO_TARGET_DIR", &target);
    crate::call::run(command.args(["build", "--quiet", "--locked", "--release"]))?;
    Ok(target.join(M4F.triple).join("release/character"))
}

const MANIFEST: &str = "tests/firmware/Cargo.toml";

fn command(folder: &Path, targets: &[Target], profile: Profile, images: &[Image]) -> Command {
    let mut command = cargo(folder, targets.first().copied().unwrap_or(M4F));
    command.args(["build", "--quiet", "--locked", "--manifest-path", MANIFEST]);
    command.args(["--profile", profile.name()]);
    command.args(targets.iter().copied().flat_map(triple));
    command.args(images.iter().flat_map(|image| ["--bin", image.name()]));
    if let Some(features) = images.first().and_then(|image| image.features()) {
        command.args(["--features", features]);
    }
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

/// Returns the build folder of a target. Builds with other flags need a separate folder, or each
/// build would invalidate the other.
fn target_folder(folder: &Path, target: Target) -> PathBuf {
    folder.join(if target.flags.is_empty() { "plain" } else { "flags" })
}
