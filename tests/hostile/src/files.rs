//! The files that everything starts from.

use models::{GOLDEN, KernelContent, Pieces};
use sinew_runtime::FileError;
use sinew_runtime::kernel::Kernel;
use std::sync::LazyLock;

/// Lists the files that everything starts from: the golden ones, and one of several parts.
///
/// # Panics
/// If a golden file is not sound.
pub fn files() -> &'static [Vec<u8>] {
    static FILES: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
        let several = several().expect("the golden files are sound");
        GOLDEN.map(<[u8]>::to_vec).into_iter().chain([several]).collect()
    });
    &FILES
}

/// Makes a file of two envelopes, four skins, two kernels and a prior: those of a rotational and of a kernel model,
/// a skin that follows nothing, a kernel with everything that there is and one with little, a face.
fn several() -> Result<Vec<u8>, FileError> {
    let [rotational, kernel, hybrid] = GOLDEN.map(Pieces::of);
    let (mut out, mut loose) = (rotational?, hybrid?);
    out.append(kernel?);
    loose.keep_vertices(3);
    loose.loosen();
    out.append(loose);
    let small = KernelContent::plain(Kernel::ThinPlate, [2, 3, 1]);
    out.append(Pieces::kernels(&[KernelContent::every(Kernel::Wendland { l: 3 }), small]));
    out.append(Pieces::face());
    Ok(out.bytes())
}
