//! Components that tests on GPUs need on a machine without a GPU: lavapipe, SwiftShader, the
//! validation layers and spirv-val.

use crate::components::{Component, install, succeeds};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Folders in which Chromium and Chrome keep SwiftShader.
const BROWSERS: [&str; 8] = [
    "/usr/lib/chromium",
    "/usr/lib64/chromium",
    "/usr/lib/chromium-browser",
    "/usr/lib64/chromium-browser",
    "/snap/chromium/current/usr/lib/chromium-browser",
    "/opt/google/chrome",
    "C:/Program Files/Google/Chrome/Application",
    "/Applications/Chromium.app/Contents/MacOS",
];

/// Folders in which the Vulkan loader looks for drivers and layers.
const LOADER: [&str; 6] = [
    "/etc/vulkan",
    "/usr/share/vulkan",
    "/usr/local/share/vulkan",
    "/usr/local/etc/vulkan",
    "/opt/homebrew/share/vulkan",
    "/opt/homebrew/etc/vulkan",
];

/// What the tests of one software device need.
const ONE: [Component; 2] = [
    Component {
        what: "lavapipe, Mesa's Vulkan driver on the CPU",
        package: "mesa-vulkan-drivers",
        found: || described(&["VK_DRIVER_FILES", "VK_ICD_FILENAMES"], "icd.d", "lvp_icd"),
    },
    Component {
        what: "the Khronos validation layers for Vulkan",
        package: "vulkan-validationlayers",
        found: || described(&["VK_LAYER_PATH"], "explicit_layer.d", "VkLayer_khronos_validation"),
    },
];

/// What the tests of every device need besides.
const MORE: [Component; 2] = [
    Component {
        what: "SwiftShader, a second Vulkan driver on the CPU, which Chromium brings",
        package: "chromium",
        found: || swiftshader().is_some(),
    },
    Component {
        what: "spirv-val of SPIRV-Tools",
        package: "spirv-tools",
        found: || succeeds(Command::new("spirv-val").arg("--version")),
    },
];

/// Installs the missing components of one device, or says how to install them.
pub(super) fn prepare() -> Result<(), String> {
    install(&ONE)
}

/// Installs the missing components of every device, or says how to install them.
pub(super) fn prepare_all() -> Result<(), String> {
    install(&MORE)
}

/// Finds SwiftShader in a browser's folder.
fn swiftshader() -> Option<PathBuf> {
    let mut all = BROWSERS.iter().map(|folder| Path::new(folder).join("vk_swiftshader_icd.json"));
    all.find(|path| path.is_file())
}

/// Returns the environment variable that adds SwiftShader to the loader's drivers; `None` if no
/// browser has installed SwiftShader.
pub(super) fn drivers() -> Option<(&'static str, OsString)> {
    const NAME: &str = "VK_ADD_DRIVER_FILES";
    let swiftshader = swiftshader()?;
    let own = std::env::var_os(NAME).unwrap_or_default();
    let mut paths: Vec<PathBuf> =
        std::env::split_paths(&own).filter(|path| !path.as_os_str().is_empty()).collect();
    if !paths.contains(&swiftshader) {
        paths.push(swiftshader);
    }
    Some((NAME, std::env::join_paths(paths).ok()?))
}

/// Returns whether a variable of the loader, or one of its folders, contains a description whose
/// name starts with `start`.
fn described(variables: &[&str], folder: &str, start: &str) -> bool {
    let named = |path: &Path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with(start) && name.ends_with(".json")
    };
    let within = |folder: &Path| {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        entries.into_iter().any(|entry| named(&entry.path()))
    };
    let variables = variables.iter().filter_map(std::env::var_os);
    let given: Vec<PathBuf> =
        variables.flat_map(|list| std::env::split_paths(&list).collect::<Vec<_>>()).collect();
    let home = std::env::var_os("HOME").map(|home| Path::new(&home).join(".local/share/vulkan"));
    let folders = LOADER.iter().map(PathBuf::from).chain(home);
    given.iter().any(|path| named(path) || within(path))
        || folders.into_iter().any(|own| within(&own.join(folder)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn installed_components_are_found() {
        let missing = crate::components::missing(&ONE);
        let missing: Vec<_> = missing.iter().map(|component| component.package).collect();
        assert!(missing.is_empty(), "`cargo xtask test` installs {missing:?}");
        assert!(!described(&[], "icd.d", "no such driver"));
        assert!(!described(&[], "no such folder", "lvp_icd"));
    }
}
