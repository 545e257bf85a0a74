//! System packages that the tests need in addition to Rust.

use crate::call::run;
use std::process::{Command, Stdio};

/// A program or library that the tests need.
pub(crate) struct Component {
    /// Name for messages.
    pub(crate) what: &'static str,
    /// Debian package.
    pub(crate) package: &'static str,
    /// Returns whether the component is installed.
    pub(crate) found: fn() -> bool,
}

/// Lists the missing components.
pub(crate) fn missing(components: &[Component]) -> Vec<&Component> {
    components.iter().filter(|component| !(component.found)()).collect()
}

/// Installs missing components with apt-get, if apt-get is available and permitted; else returns
/// the command to run.
pub(crate) fn install(components: &[Component]) -> Result<(), String> {
    let missing = missing(components);
    if missing.is_empty() {
        return Ok(());
    }
    let packages = missing.iter().map(|component| component.package).collect::<Vec<_>>().join(" ");
    if !starts("apt-get") {
        let what: Vec<_> = missing.iter().map(|component| component.what).collect();
        return Err(format!(
            "not found: {}. Install them with this system's package manager (Debian calls them {packages})",
            what.join("; ")
        ));
    }
    let advice = format!("run `sudo apt-get update && sudo apt-get install -y {packages}`");
    let root = Command::new("id").arg("-u").output();
    let root = root.is_ok_and(|id| String::from_utf8_lossy(&id.stdout).trim() == "0");
    if !root && !succeeds(Command::new("sudo").args(["-n", "true"])) {
        return Err(format!("{packages} must be installed: {advice}"));
    }
    let apt_get = |arguments: &str| {
        let mut command = Command::new(if root { "env" } else { "sudo" });
        command.args(if root { &[][..] } else { &["-n", "env"][..] });
        command.args(["DEBIAN_FRONTEND=noninteractive", "apt-get"]);
        run(command.args(arguments.split_whitespace()))
    };
    let install = format!("install -y --no-install-recommends {packages}");
    // The package list may be present while the network is not.
    let installed =
        apt_get(&install).or_else(|_| apt_get("update").and_then(|()| apt_get(&install)));
    installed.map_err(|error| format!("{error}; {advice}"))?;
    match self::missing(components).first() {
        None => Ok(()),
        Some(Component { what, package, .. }) => {
            Err(format!("{package} is installed, but {what} is still not found"))
        }
    }
}

/// Returns whether a program starts: it prints its version.
pub(crate) fn starts(program: &str) -> bool {
    succeeds(Command::new(program).arg("--version"))
}

/// Runs a program without output and returns whether it succeeds.
pub(crate) fn succeeds(command: &mut Command) -> bool {
    let quiet = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    quiet.status().is_ok_and(|status| status.success())
}
