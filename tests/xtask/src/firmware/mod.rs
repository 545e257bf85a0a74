//! Checks of firmware: equal bits on every target, no allocator, no panic, and costs within budget.

mod budget;
mod build;
mod elf;
mod targets;

use build::{Image, Profile, control_fails, path};
use elf::Elf;
use std::path::Path;
use std::process::Command;
use std::thread;
use targets::{M4F, STM32F4, TARGETS, Target};

/// Builds and runs the images, and checks bits, panics, allocators and costs.
pub(crate) fn firmware() -> Result<(), String> {
    targets::prepare()?;
    let folder = crate::call::target_folder()?.join("nested/firmware");
    bake_models(&folder.join("models"))?;
    build::lint(&folder)?;
    let running = run_bits(&folder)?;
    build::others(&folder)?;
    same_bits(running)?;
    let example = build::example(&folder)?;
    let printed = STM32F4.run(&example)?;
    shown("../../runtime/examples/firmware/src/main.rs", &printed, "confidence ")?;
    for (image, starts_with) in [(Image::Servo, "angle "), (Image::Sensor, "fine samples ")] {
        let printed = M4F.run(&path(&folder, M4F, Profile::Release, image))?;
        shown(&format!("src/bin/{}.rs", image.name()), &printed, starts_with)?;
    }
    no_panic(&folder)?;
    no_allocator(&folder)?;
    costs(&folder, &example)
}

/// Bakes the models that the images contain.
fn bake_models(folder: &Path) -> Result<(), String> {
    std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    // As part of the workspace, to share the build of `cargo test --workspace`.
    crate::call::cargo("build --locked --workspace --example firmware_models", &[])?;
    let program = crate::call::target_folder()?.join("debug/examples/firmware_models");
    crate::call::run(Command::new(program).arg(folder))
}

/// A target, and its running image with the future output.
type Run = (Target, thread::JoinHandle<Result<String, String>>);

/// Starts the poses on every target, in parallel with the next steps.
fn run_bits(folder: &Path) -> Result<Vec<Run>, String> {
    let mut targets = Vec::new();
    for target in TARGETS {
        if target.runs_here()? {
            targets.push(target);
        }
    }
    build::bits(folder, &targets)?;
    let run = |target: Target| {
        let image = path(folder, target, Profile::Release, Image::Bits);
        (target, thread::spawn(move || target.run(&image)))
    };
    Ok(targets.into_iter().map(run).collect())
}

/// Compares the output of each target with the output of the first target, the host.
fn same_bits(running: Vec<Run>) -> Result<(), String> {
    let mut first: Option<String> = None;
    for (target, thread) in running {
        let found = thread.join().map_err(|_| format!("{}: the run panicked", target.name))??;
        let expected = first.get_or_insert_with(|| found.clone());
        compare(target.name, expected, &found)?;
        eprintln!("xtask: {}: the same bits", target.name);
    }
    Ok(())
}

/// Compares the output of two targets line by line.
fn compare(target: &str, expected: &str, found: &str) -> Result<(), String> {
    if !found.ends_with("end\n") {
        return Err(format!("{target}: did not run to its end: {found}"));
    }
    let differs = expected.lines().zip(found.lines()).find(|(a, b)| a != b);
    match differs {
        Some((expected, found)) => Err(format!("{target}: expected `{expected}`, found `{found}`")),
        None if expected.lines().count() != found.lines().count() => {
            Err(format!("{target}: expected {} lines", expected.lines().count()))
        }
        None => Ok(()),
    }
}

/// Checks the output of a program, and that the README shows its source.
fn shown(source: &str, printed: &str, starts_with: &str) -> Result<(), String> {
    if !printed.starts_with(starts_with) {
        return Err(format!("{source} printed `{printed}`"));
    }
    let read = |path: &str| {
        let path = format!("tests/firmware/{path}");
        std::fs::read_to_string(&path).map_err(|error| format!("{path}: {error}"))
    };
    let shown = format!("```rust\n{}```\n", read(source)?);
    if read("README.md")?.contains(&shown) {
        Ok(())
    } else {
        Err(format!("tests/firmware/README.md does not show {source} as it is"))
    }
}

/// Checks that the proof links without a panic, and that the control with a panic does not link.
fn no_panic(folder: &Path) -> Result<(), String> {
    for profile in Profile::ALL {
        control_fails(folder, M4F, profile)?;
    }
    eprintln!("xtask: no panic can be reached; the control with a panic does not link");
    Ok(())
}

/// Searches the images for an allocator, and checks that the search finds the control's allocator.
fn no_allocator(folder: &Path) -> Result<(), String> {
    let symbols = |image| -> Result<Vec<String>, String> {
        Ok(Elf::read(&path(folder, M4F, Profile::Release, image))?.allocator())
    };
    for image in [Image::Proof, Image::Bits, Image::Cost, Image::Servo, Image::Sensor] {
        let found = symbols(image)?;
        if !found.is_empty() {
            return Err(format!("{}: an allocator is linked: {found:?}", image.name()));
        }
    }
    if symbols(Image::ControlAlloc)?.is_empty() {
        return Err("the search for an allocator does not find the control's".to_owned());
    }
    eprintln!("xtask: no allocator is linked");
    Ok(())
}

/// Measures, prints and judges the figures.
fn costs(folder: &Path, example: &Path) -> Result<(), String> {
    let mut figures = Vec::new();
    for profile in Profile::ALL {
        for image in [Image::Cost, Image::CostServo, Image::CostNormals] {
            let image = path(folder, M4F, profile, image);
            let (printed, again) = (M4F.run(&image)?, M4F.run(&image)?);
            if printed != again {
                return Err(format!("two runs differ:\n{printed}\n{again}"));
            }
            for line in printed.lines() {
                if let Some((name, value)) = line.rsplit_once(' ') {
                    let value = value.parse().map_err(|_| format!("`{line}` holds no number"))?;
                    figures.push((format!("{} {name}", profile.name()), value));
                }
            }
        }
    }
    for profile in Profile::ALL {
        let bytes = |image| -> Result<u64, String> {
            Ok(Elf::read(&path(folder, M4F, profile, image))?.loaded_bytes())
        };
        let bare = bytes(Image::Bare)?;
        for (name, image) in [
            ("rotational", Image::SizeRotational),
            ("any", Image::SizeAny),
            ("all", Image::SizeAll),
            ("servo", Image::SizeServo),
            ("sensor", Image::SizeSensor),
            ("normals", Image::SizeNormals),
            ("views", Image::SizeViews),
            ("shapes", Image::SizeShapes),
        ] {
            figures.push((format!("{} {name} code", profile.name()), bytes(image)? - bare));
        }
    }
    let example = Elf::read(example)?;
    figures.push(("small example flash".to_owned(), example.loaded_bytes()));
    figures.push(("small example ram".to_owned(), example.ram_bytes()));
    let path = "tests/firmware/budget.txt";
    let budget = std::fs::read_to_string(path).map_err(|error| format!("{path}: {error}"))?;
    let judged = budget::judge(&figures, &budget)?;
    eprint!("{}", judged.table);
    if judged.failures.is_empty() { Ok(()) } else { Err(judged.failures.join("\n")) }
}

#[cfg(test)]
mod tests {
    use super::compare;

    #[test]
    fn one_other_bit_is_detected() {
        let sound = "a pose 01\na skin 02\nend\n";
        assert_eq!(compare("host", sound, sound), Ok(()));
        let other = compare("host", sound, "a pose 01\na skin 03\nend\n");
        assert_eq!(other, Err("host: expected `a skin 02`, found `a skin 03`".to_owned()));
        assert!(compare("host", sound, "a pose 01\nend\n").is_err());
        assert!(compare("host", sound, "a pose 01\n").is_err());
        assert!(compare("host", "", "").is_err());
    }
}
