//! Prints hashes of every stage, for the golden files and for models baked for this run.

#[cfg(feature = "filter")]
use crate::bits::filters;
#[cfg(feature = "kernel")]
use crate::bits::kernels;
#[cfg(feature = "prior")]
use crate::bits::priors;
#[cfg(feature = "views")]
use crate::bits::views;
use crate::bits::{Found, GOLDEN, Memory, POSES, STAGES, hashes};
use crate::memory::take;
use crate::platform::print;
use crate::say;
#[cfg(feature = "filter")]
use sinew_runtime::Filter;
#[cfg(feature = "kernel")]
use sinew_runtime::KernelMap;
#[cfg(feature = "prior")]
use sinew_runtime::Prior;
#[cfg(feature = "views")]
use sinew_runtime::Views;
use sinew_runtime::{Envelope, Model, Skin};

/// Models that the trainer baked for this run, by name.
///
/// Another CPU may bake other bytes, so their hashes are compared between targets but not stored.
const BAKED: [(&str, &[u8]); 2] = [
    ("demo rotational", include_bytes!(concat!(env!("SINEW_MODELS"), "/demo-rotational.snw"))),
    ("demo kernel", include_bytes!(concat!(env!("SINEW_MODELS"), "/demo-kernel.snw"))),
];

/// Poses per baked model: without a float unit a character takes fifty times as long as a golden
/// model.
const BAKED_POSES: usize = POSES / 4;

/// Prints a hash for each stage and model; returns whether the golden files have the promised
/// hashes.
pub fn bits() -> bool {
    let Some(memory) = take() else { return false };
    let mut sound = true;
    let golden = GOLDEN.iter().map(|golden| (golden.name, golden.file));
    let golden = golden.map(|(name, file)| (name, file, POSES));
    let baked = BAKED.map(|(name, file)| (name, file, BAKED_POSES));
    for (name, file, poses) in golden.chain(baked) {
        let model = Model::from_bytes(file).ok();
        let views =
            model.as_ref().and_then(|model| model.first::<Envelope>().zip(model.first::<Skin>()));
        let Some((envelope, skin)) = views else {
            say!("{name}: not loaded");
            return false;
        };
        match hashes(envelope, skin, poses, 0.0, memory) {
            Ok(Found { bits, faded, finite }) => {
                for (stage, bits) in STAGES.iter().zip(bits) {
                    say!("{name} {stage} {bits:016x}");
                }
                say!("{name} faded {faded}");
                let promised = GOLDEN.iter().find(|golden| golden.name == name);
                let kept = promised.is_none_or(|golden| golden.bits == bits);
                if !kept {
                    say!("{name}: not the bits of METHOD 7");
                }
                sound &= kept && finite;
            }
            Err(error) => {
                say!("{name}: {error}");
                sound = false;
            }
        }
    }
    sound &= of_kernels(memory);
    sound &= of_views(memory);
    sound &= of_pins();
    sound &= of_filter(memory);
    print("end\n");
    sound
}

/// Prints a hash of each golden kernel; returns whether they are the promised hashes.
#[cfg(feature = "kernel")]
fn of_kernels(memory: &mut Memory) -> bool {
    let Some(model) = kernels::load() else {
        say!("kernels: not loaded");
        return false;
    };
    let mut sound = model.all::<KernelMap>().count() == kernels::BITS.len();
    for (kernel, promised) in model.all::<KernelMap>().zip(kernels::BITS) {
        match kernels::hash(&kernel, 0.0, &mut memory.scratch, &mut memory.skin) {
            Ok(bits) => {
                say!("kernel {} {bits:016x}", kernel.name());
                sound &= bits == promised;
            }
            Err(error) => {
                say!("kernel {}: {error}", kernel.name());
                sound = false;
            }
        }
    }
    sound
}

/// Prints nothing without the part kernel.
#[cfg(not(feature = "kernel"))]
fn of_kernels(_: &mut Memory) -> bool {
    true
}

/// Prints a hash of each golden object of key views; returns whether they are the promised hashes.
#[cfg(feature = "views")]
fn of_views(memory: &mut Memory) -> bool {
    let mut sound = true;
    for (file, promised) in views::VIEWS.into_iter().zip(views::BITS) {
        let model = views::load(file);
        let Some((model, object)) =
            model.as_ref().and_then(|model| Some((model, model.first::<Views>()?)))
        else {
            say!("views: not loaded");
            return false;
        };
        match views::hash(model, object, 0.0, &mut memory.scratch) {
            Ok(bits) => {
                say!("views {} {bits:016x}", object.is_transferred());
                sound &= bits == promised;
            }
            Err(error) => {
                say!("views: {error}");
                sound = false;
            }
        }
    }
    sound
}

/// Prints nothing without views.
#[cfg(not(feature = "views"))]
fn of_views(_: &mut Memory) -> bool {
    true
}

/// Prints a hash of the golden face's pins; returns whether it is the promised hash.
#[cfg(feature = "prior")]
fn of_pins() -> bool {
    let model = priors::load();
    let Some((prior, skin)) =
        model.as_ref().and_then(|model| model.first::<Prior>().zip(model.first::<Skin>()))
    else {
        say!("pins: not loaded");
        return false;
    };
    match priors::hash(prior, skin, 0.0) {
        Ok(bits) => {
            say!("pins {bits:016x}");
            bits == priors::BITS
        }
        Err(error) => {
            say!("pins: {error}");
            false
        }
    }
}

/// Prints nothing without priors.
#[cfg(not(feature = "prior"))]
fn of_pins() -> bool {
    true
}

/// Prints a hash of the golden filter; returns whether it is the promised hash.
#[cfg(feature = "filter")]
fn of_filter(memory: &mut Memory) -> bool {
    let model = filters::load();
    let Some(filter) = model.as_ref().and_then(|model| model.first::<Filter>()) else {
        say!("filter: not loaded");
        return false;
    };
    match filters::hash(&filter, 0.0, &mut memory.scratch, &mut memory.skin) {
        Ok(bits) => {
            say!("filter {bits:016x}");
            bits == filters::BITS
        }
        Err(error) => {
            say!("filter: {error}");
            false
        }
    }
}

/// Prints nothing without the part filter.
#[cfg(not(feature = "filter"))]
fn of_filter(_: &mut Memory) -> bool {
    true
}
