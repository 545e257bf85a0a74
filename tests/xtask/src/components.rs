//! What the tests need beyond Rust, as packages of the system.

use crate::call::run;
use std::process::{Command, Stdio};

/// Something that the tests need.
pub(crate) struct Component {
    /// What it is.
    pub(crate) what: &'static str,
    /// Debian's package.
    pub(crate) package: &'static str,
    /// Whether it is there.
    pub(crate) found: fn() -> bool,
}

/// Lists what is not there.
pub(crate) fn missing(components: &[Component]) -> Vec<&Component> {
    components.iter().filter(|component| !(component.found)()).collect()
}

/// Installs what is missing with apt-get, where that is there and allowed; else says what to
/// install.
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
    // The list of packages may be there already, and then there may be no network.
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

/// Whether a program is there: it tells its version.
pub(crate) fn starts(program: &str) -> bool {
    succeeds(Command::new(program).arg("--version"))
}

/// Whether a program runs and is content, its output unseen.
pub(crate) fn succeeds(command: &mut Command) -> bool {
    let quiet = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    quiet.status().is_ok_and(|status| status.success())
}
