//! The committed SPIR-V belongs to the sources, is valid, and has the bindings of the layout.

use naga::front::wgsl;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{AddressSpace, Module, StorageAccess, TypeInner};
use shaders::{SUMS, folder, sources, sums};
use sinew_gpu::layout::{
    Batch, DeviceLimits, FilterBatch, KernelBatch, Plan, Resource, ShapesBatch, Stage, WORKGROUP,
};
use sinew_runtime::filter::Samples;
use sinew_runtime::{Envelope, Filter, KernelMap, Model, Skin};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Parses the WGSL of every stage.
fn modules() -> impl Iterator<Item = (Stage, Module)> {
    Stage::ALL.into_iter().map(|stage| {
        let module = wgsl::parse_str(stage.wgsl());
        (stage, module.unwrap_or_else(|e| panic!("{}", e.emit_to_string(stage.wgsl()))))
    })
}

#[test]
fn every_stage_has_a_shader() {
    let found = sources(&folder()).unwrap();
    let stems = |stems: &mut dyn Iterator<Item = String>| stems.collect::<BTreeSet<_>>();
    let of_files = found.iter().map(|(glsl, _)| glsl.file_stem().unwrap().to_str().unwrap().into());
    let of_stages = Stage::ALL.map(|stage| stage.name().to_owned());
    assert_eq!(stems(&mut of_files.into_iter()), stems(&mut of_stages.into_iter()));
}

/// Returns the lines of the sums that differ from the committed ones.
fn changed(folder: &Path) -> Vec<String> {
    let committed = fs::read_to_string(folder.join(SUMS)).unwrap();
    let found = sums(folder).unwrap();
    assert_eq!(committed.lines().count(), found.lines().count());
    let pairs = committed.lines().zip(found.lines());
    pairs.filter(|(committed, found)| committed != found).map(|(_, own)| own.to_owned()).collect()
}

#[test]
fn the_committed_spirv_is_of_this_glsl() {
    let changed = changed(&folder());
    assert!(changed.is_empty(), "run `cargo xtask shaders`: {changed:?}");
}

#[test]
fn one_changed_byte_is_seen() {
    let copy = std::env::temp_dir().join(format!("sinew-shaders-{}", std::process::id()));
    fs::create_dir_all(copy.join("spirv")).unwrap();
    for line in sums(&folder()).unwrap().lines() {
        let file = line.split_once("  ").unwrap().1;
        fs::copy(folder().join(file), copy.join(file)).unwrap();
    }
    fs::copy(folder().join(SUMS), copy.join(SUMS)).unwrap();
    assert!(changed(&copy).is_empty());
    for file in ["frame.glsl", "spirv/skin.spv"] {
        let sound = fs::read(copy.join(file)).unwrap();
        let mut bytes = sound.clone();
        bytes[9] ^= 1;
        fs::write(copy.join(file), bytes).unwrap();
        let changed = changed(&copy);
        assert!(changed.len() == 1 && changed[0].ends_with(file), "{changed:?}");
        fs::write(copy.join(file), sound).unwrap();
    }
    fs::remove_dir_all(&copy).unwrap();
}

#[test]
fn the_spirv_is_valid() {
    for (_, spirv) in sources(&folder()).unwrap() {
        let run =
            Command::new("spirv-val").args(["--target-env", "vulkan1.0"]).arg(&spirv).output();
        let run = run.expect("spirv-val is there: install spirv-tools");
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    }
}

#[test]
fn the_wgsl_is_valid_and_needs_nothing_optional() {
    for (stage, module) in modules() {
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
        let valid = validator.validate(&module);
        assert!(valid.is_ok(), "{}: {:?}", stage.name(), valid.err());
        let [entry] = &module.entry_points[..] else { panic!("{} entry points", stage.name()) };
        assert_eq!((entry.name.as_str(), entry.workgroup_size), ("main", [WORKGROUP, 1, 1]));
    }
}

#[test]
fn bindings_match_the_layout() {
    for (stage, module) in modules() {
        let mut found = vec![None; stage.bindings().len()];
        for (_, global) in module.global_variables.iter() {
            let Some(place) = &global.binding else { continue };
            assert_eq!(place.group, 0);
            found[place.binding as usize] = Some((global.name.clone().unwrap(), global.space));
        }
        for (binding, found) in stage.bindings().iter().zip(found) {
            let (name, space) = found.unwrap();
            assert_eq!(name, binding.resource.name());
            let expected = match (binding.resource, binding.writable) {
                (Resource::Params, _) => AddressSpace::Uniform,
                (_, false) => AddressSpace::Storage { access: StorageAccess::LOAD },
                (_, true) => {
                    AddressSpace::Storage { access: StorageAccess::LOAD | StorageAccess::STORE }
                }
            };
            assert_eq!(space, expected, "{}, {name}", stage.name());
        }
    }
}

/// Returns the names of the uniform block's members, in order.
fn members_of(module: &Module) -> Vec<String> {
    let (_, block) = module
        .types
        .iter()
        .find(|(_, t)| t.name.as_deref() == Some("Params"))
        .expect("the module has a uniform block");
    let TypeInner::Struct { members, .. } = &block.inner else { panic!("the block is no struct") };
    members.iter().map(|member| member.name.clone().expect("members have names")).collect()
}

/// Loads a golden model.
fn golden(name: &str) -> Model<Vec<u8>> {
    let bytes = fs::read(folder().join("../tests/golden").join(name)).expect("the golden exists");
    Model::from_bytes(bytes).expect("the golden loads")
}

#[test]
fn the_uniform_block_matches_the_layout() {
    const LIMITS: &DeviceLimits = &DeviceLimits::DOWNLEVEL;
    let [of_envelope, of_kernel] = ["envelope-11-kernel.snw", "kernel-11.snw"].map(golden);
    let (envelope, skin) =
        (of_envelope.first::<Envelope>().unwrap(), of_envelope.first::<Skin>().unwrap());
    let batch = Batch::skinned(&envelope, &skin, 1);
    let envelope = Plan::new(&of_envelope, &envelope, &batch, LIMITS).unwrap();
    let kernel = of_kernel.first::<KernelMap>().unwrap();
    let batch = KernelBatch::new(&kernel, 1);
    let kernel = Plan::of_kernel(&of_kernel, &kernel, &batch, LIMITS).unwrap();
    let of_skin = golden("shapes-11-f32.snw");
    let skin = of_skin.first::<Skin>().unwrap();
    let shapes = Plan::of_shapes(&of_skin, &skin, &ShapesBatch::new(&skin, 1), LIMITS).unwrap();
    let of_filter = golden("filter-11.snw");
    let filter = of_filter.first::<Filter>().unwrap();
    let batch = FilterBatch::new(&filter, Samples::of_signal(filter.tap_len()));
    let filter = Plan::of_filter(&of_filter, &filter, &batch, LIMITS).unwrap();
    let plans = [
        (envelope, "params.glsl"),
        (kernel, "kernel_params.glsl"),
        (shapes, "shapes_params.glsl"),
        (filter, "filter_params.glsl"),
    ];
    for (plan, file) in plans {
        // Kernels, shapes and filters have their own uniform blocks.
        const ALONE: [Stage; 3] = [Stage::Kernel, Stage::Shapes, Stage::Filter];
        let alone = ALONE.map(|stage| plan.stages().eq([stage]));
        let is_own = |stage: Stage| ALONE.map(|own| own == stage) == alone;
        let chunk = &plan.chunks()[0];
        let written: Vec<_> = chunk.params().iter().map(|(name, _)| *name).collect();
        let bytes = chunk.span(Resource::Params).unwrap().bytes;
        assert_eq!(bytes, (4 * written.len() as u64).next_multiple_of(16));
        for (stage, module) in modules().filter(|(stage, _)| is_own(*stage)) {
            assert_eq!(members_of(&module), written, "{}", stage.name());
        }
        let glsl = fs::read_to_string(folder().join(file)).unwrap();
        let block = glsl.split(['{', '}']).nth(1).unwrap();
        let members = block.lines().filter_map(|line| line.trim().strip_prefix("uint "));
        let members: Vec<_> = members.map(|member| member.trim_end_matches(';')).collect();
        assert_eq!(members, written);
    }
}
