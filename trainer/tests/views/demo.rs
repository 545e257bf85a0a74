//! The sets of the demo, and hand drawings: reading and training.

use super::common::{Folder, most, rms, squares};
use models::shared;
use sinew_trainer::views::demo::write;
use sinew_trainer::views::fit::{FitOptions, fit};
use sinew_trainer::views::set::JOINTS;
use sinew_trainer::views::set::{Element, ViewSet, read, read_drawing};

/// Largest errors of points in the demo's test views, pixels: RMS and maximum.
const BETWEEN: [f64; 2] = [0.6, 1.5];

#[test]
fn sets_read_back_as_they_were_written() {
    let folder = Folder::new("demo");
    let sets = write(&folder.path("")).unwrap();
    let names: Vec<&str> = sets.iter().map(|set| set.name.as_str()).collect();
    assert_eq!(names, ["figure", "panel", "head"]);
    for set in &sets {
        let found = read(&folder.path(&set.name).join("views.json"), None).unwrap();
        assert_eq!(
            (&found.name, found.size, &found.layers[0].elements),
            (&set.name, set.size, &set.layers[0].elements)
        );
        for (found, set) in found.maps.iter().zip(&set.maps) {
            assert_eq!((&found.name, &found.parameters), (&set.name, &set.parameters));
            for (found, view) in found.train.iter().zip(&set.train) {
                assert_eq!((&found.values, &found.depths), (&view.values, &view.depths));
                assert_eq!((&found.points, &found.visible), (&view.points, &view.visible));
                assert_eq!(found.image.is_some(), view.image.is_some());
            }
        }
        let keys = found.key_views();
        assert!(!keys.is_empty());
        for (map, view) in keys {
            let image = found.maps[map].train[view].image.as_ref().unwrap();
            let picture = image.load(found.size).unwrap();
            let covered = picture.rgba.chunks(4).filter(|pixel| pixel[3] > 0).count();
            assert!(covered > 4000, "{}: {covered}", image.file.display());
        }
    }
}

#[test]
fn test_views_of_the_demos_are_met() {
    let folder = Folder::new("demo-fit");
    for set in write(&folder.path("")).unwrap() {
        for examples in &set.maps {
            let map = fit(examples, &[], FitOptions::default()).unwrap();
            let met = examples.train.iter().flat_map(|view| squares(&map, view));
            let met = most(&met.collect::<Vec<_>>());
            assert!(met < 1e-3, "{} {}: {met} px at the examples", set.name, examples.name);
            let between: Vec<f64> =
                examples.test.iter().flat_map(|view| squares(&map, view)).collect();
            println!(
                "{} {}: {:?} {:?}",
                set.name, examples.name, map.choice.inputs, map.choice.points
            );
            if !between.is_empty() {
                println!("  between: {:.4} px, most {:.4}", rms(&between), most(&between));
                assert!(rms(&between) < BETWEEN[0] && most(&between) < BETWEEN[1]);
            }
        }
    }
}

/// Returns the share of a drawing's covered pixels that its triangles cover at rest.
fn covered(set: &ViewSet) -> f64 {
    let (map, view) = set.key_views()[0];
    let rest = &set.maps[map].train[view];
    let picture = rest.image.as_ref().unwrap().load(set.size).unwrap();
    let known = rest.known();
    let cross = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let is_covered = |p: [f64; 2]| {
        set.layers[0].elements.iter().any(|element| {
            let &[a, b, c] = element.vertices() else { return false };
            let [a, b, c] = [known[a], known[b], known[c]];
            let turns = [cross(a, b, p), cross(b, c, p), cross(c, a, p)];
            turns.iter().all(|turn| *turn >= 0.0) || turns.iter().all(|turn| *turn <= 0.0)
        })
    };
    let [width, height] = set.size;
    let drawn: Vec<[f64; 2]> = (0..width * height)
        .filter(|place| picture.rgba[4 * place + 3] > 0)
        .step_by(7)
        .map(|place| [(place % width) as f64 + 0.5, (place / width) as f64 + 0.5])
        .collect();
    drawn.iter().filter(|p| is_covered(**p)).count() as f64 / drawn.len() as f64
}

#[test]
fn a_drawing_is_covered_by_triangles_that_follow_its_bones() {
    let folder = Folder::new("drawing");
    write(&folder.path("")).unwrap();
    let mut drawings = vec![folder.path("figure")];
    for name in ["char1", "char2", "char4"] {
        drawings.extend(shared(&format!("animated-drawings/{name}")));
    }
    for drawing in drawings {
        let set = read_drawing(&drawing.join("char_cfg.yaml")).unwrap();
        let share = covered(&set);
        println!(
            "{}: {} points, {} triangles, {share:.4} covered",
            set.name,
            set.point_len(),
            set.element_len()
        );
        assert!(share > 0.999, "{}: {share}", set.name);
        assert!(set.point_len() > 60 && set.point_len() < 800);
        assert!(
            set.layers[0].elements.iter().all(|element| matches!(element, Element::Triangle(_)))
        );
        let [walk, jump] = &set.maps[..] else { panic!("two motions") };
        let height = |view: &sinew_trainer::views::set::View| view.known()[0][1];
        assert!(height(&jump.train[3]) < height(&jump.train[0]) - 5.0, "it leaves the ground");
        let foot = JOINTS.iter().position(|(name, _)| *name == "left_foot").unwrap();
        let moved = walk.train[2].known()[foot][0] - walk.train[6].known()[foot][0];
        assert!(moved.abs() > 10.0, "it strides: {moved}");
    }
}
