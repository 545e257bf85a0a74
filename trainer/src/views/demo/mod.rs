//! Demo sets: a drawn figure that walks and jumps, a panel in perspective that bends, and a head that turns all the way
//! round.

mod figure;
mod paint;
mod solids;

use super::set::{ViewSet, as_json, read_drawing};
use crate::Error;
use crate::page::picture::Picture;
use std::path::Path;

/// Writes each set to its own folder, with `views.json` and its pictures. The figure is also written as a drawing:
/// `char_cfg.yaml` with `texture.png` and `mask.png`.
///
/// # Errors
/// A file cannot be written.
pub fn write(folder: &Path) -> Result<Vec<ViewSet>, Error> {
    let own = folder.join("figure");
    let (description, pictures) = figure::drawn();
    save(&own, &pictures, "char_cfg.yaml", &description)?;
    let figure = read_drawing(&own.join("char_cfg.yaml"))?;
    save(&own, &[], "views.json", &as_json(&figure, &own).to_string())?;
    let mut sets = vec![figure];
    for (set, pictures) in [solids::panel(), solids::head()] {
        let own = folder.join(&set.name);
        save(&own, &pictures, "views.json", &as_json(&set, &own).to_string())?;
        sets.push(set);
    }
    Ok(sets)
}

fn save(
    folder: &Path,
    pictures: &[(String, Picture)],
    name: &str,
    text: &str,
) -> Result<(), Error> {
    let write = |name: &str, bytes: &[u8]| {
        crate::files::write(&folder.join(name), bytes).map_err(Error::write)
    };
    std::fs::create_dir_all(folder).map_err(Error::write)?;
    for (name, picture) in pictures {
        write(name, &picture.png()?)?;
    }
    write(name, text.as_bytes())
}
