//! Seed files, from which every mutation starts.

use models::{
    FilterContent, GOLDEN, GOLDEN_KIND, GOLDEN_STRETCH, JOINTLESS, KernelContent, Pieces,
    RecordContent, ShapeContent, ViewsContent,
};
use sinew_runtime::FileError;
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::Element;
use sinew_runtime::kernel::Kernel;
use sinew_runtime::views::Layer;
use std::sync::LazyLock;

/// Lists the seed files: the golden files, and one file of several parts.
///
/// # Panics
/// If a golden file is damaged.
pub fn files() -> &'static [Vec<u8>] {
    static FILES: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
        let several = several().expect("the golden files are sound");
        let goldens =
            GOLDEN.into_iter().chain(GOLDEN_STRETCH).chain(GOLDEN_KIND).map(<[u8]>::to_vec);
        goldens.chain([several]).collect()
    });
    &FILES
}

/// Makes a file of three envelopes, five skins, four kernels, a prior, views and a filter. The
/// envelopes are a rotational model, a kernel model and one without joints. One skin follows
/// nothing; two skins have shapes. One kernel has every feature and one has few. The prior is a
/// face. The views have two maps; their first layer has depth and clips the second.
fn several() -> Result<Vec<u8>, FileError> {
    let [rotational, kernel] = GOLDEN.map(Pieces::of);
    let (mut out, kernel) = (rotational?, kernel?);
    let mut loose = kernel.clone();
    out.set_shapes(&ShapeContent::sample(Element::I8, 6, 24));
    out.append(kernel);
    loose.keep_vertices(3);
    loose.loosen();
    loose.set_shapes(&ShapeContent::sample(Element::F16, 6, 3));
    out.append(loose);
    out.append(Pieces::sample(Predictor::Kernel, JOINTLESS));
    let small = KernelContent::plain(Kernel::ThinPlate, [2, 3, 1]);
    out.append(Pieces::kernels(&[KernelContent::every(Kernel::Wendland { l: 3 }), small]));
    out.append(Pieces::face());
    let mut object = Pieces::kernels(
        &[("walk", 51), ("jump", 52)].map(|(name, seed)| KernelContent::map(name, seed)),
    );
    let mut content = ViewsContent::sample(vec![0, 1], false);
    for layer in content.layers.iter_mut().take(1) {
        layer.flags = Layer::DEPTH;
    }
    object.add_views(&content);
    out.append(object);
    out.add_filter(&FilterContent::sample(2, 5));
    out.add_record(&RecordContent::sample());
    Ok(out.bytes())
}
