//! Falloffs of other tools as kernels of ours, and how a reference names them all.

use crate::common::json;
use sinew_runtime::kernel::Kernel;
use sinew_trainer::regression::function::Exact;
use sinew_trainer::scattered::compat::canonical::Falloff;

#[test]
fn falloffs_are_their_own_formulas() {
    type Formula = fn(f64, f64) -> f64;
    let all: [(Falloff, Formula); 5] = [
        (Falloff::Gaussian, |d, r| (-d / (r * r)).exp()),
        (Falloff::Exponential, |d, r| (-2.0 * d / r).exp()),
        (Falloff::Linear, |d, r| (1.0 - d / r).max(0.0)),
        (Falloff::Cubic, |d, r| (1.0 - (d / r).powi(3)).max(0.0)),
        (Falloff::Quintic, |d, r| (1.0 - (d / r).powi(5)).max(0.0)),
    ];
    for (falloff, formula) in all {
        for radius in [0.3, 1.0, 2.5] {
            let found = falloff.canonical(radius);
            for step in 0..50 {
                let d = 0.07 * f64::from(step);
                let ours = found.factor * found.kernel.exact((found.epsilon * d).powi(2));
                assert!((ours - formula(d, radius)).abs() < 1e-14, "{falloff:?} {radius} {d}");
            }
        }
    }
}

#[test]
fn every_mapping_of_the_reference_has_one_of_ours() {
    let Some(file) = json("../reference/canonical_map.json") else { return };
    let own = [
        ("weightDriver \"gaussian 1\", Unreal/RigLogic \"Gaussian\"", Falloff::Gaussian),
        ("Unreal/RigLogic Exponential", Falloff::Exponential),
    ];
    let names: Vec<&str> = file.as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(names.len(), 9);
    assert_eq!(names.iter().filter(|name| name.starts_with("seed ")).count(), 6);
    for (start, falloff) in own {
        let name = names.iter().find(|name| name.starts_with(start)).unwrap();
        assert!(name.contains("-> matern12"));
        assert_eq!(falloff.canonical(1.0).kernel, Kernel::Matern12);
        assert!(name.ends_with(if falloff == Falloff::Gaussian { "1/sigma^2" } else { "2/sigma" }));
    }
    assert!(names.iter().any(|name| name.ends_with("Linear/Cubic/Quintic -> hat(p) eps=1/sigma")));
}
