//! Pictures between key views, compared with true pictures: PSNR of premultiplied RGBA.

use super::common::{hull, is_inside};
use super::flat::{drawn, made_of, mean_and_worst, psnr};
use models::shared;
use sinew_runtime::Model;
use sinew_trainer::page::picture::Picture;
use sinew_trainer::views::evaluate::PictureError;
use sinew_trainer::views::player::multiplied;
use sinew_trainer::views::set::{Layer, Values, ViewSet, read};

/// Smallest PSNR of the character's test views in dB: mean and worst, in layers.
const LAYERS: [f64; 2] = [34.0, 31.0];
/// Smallest mean PSNR of the character's test views in one layer, dB.
const FLAT: f64 = 24.0;
/// PSNR of the character's test views by linear interpolation of pixels, dB.
const MIXED: [f64; 3] = [22.1, 21.6, 21.1];
/// Largest change along a path, over the median.
const JUMP: f64 = 1.5;
/// Smallest PSNR of the head's left-out views in dB: mean and worst.
const HEAD: [f64; 2] = [34.0, 28.0];
/// Largest number of uncovered pixels in the head's left-out views.
const HOLES: usize = 27;

/// Measures the PSNR of the test views of a set with one motion.
fn tested(set: &ViewSet, model: &Model<Vec<u8>>) -> Vec<f64> {
    let one = |view: &sinew_trainer::views::set::View| {
        let truth = view.image.as_ref().unwrap().load(set.size).unwrap();
        psnr(&drawn(model, &view.values), &multiplied(&truth))
    };
    set.maps[0].test.iter().map(one).collect()
}

#[test]
fn a_character_in_layers_turns_as_it_is_drawn_and_does_not_jump() {
    let Some(file) = shared("character-2d/character.json") else { return };
    let set = read(&file, None).unwrap();
    let (_, model) = made_of(&set);
    let all = tested(&set, &model);
    let [mean, worst] = mean_and_worst(&all);
    println!("character in layers: {mean:.2} dB, worst {worst:.2}");
    assert!(mean >= LAYERS[0] && worst >= LAYERS[1], "{all:?}");
    let turn = (0..41).map(|step| [f64::from(step) / 20.0 - 1.0, 0.0]);
    let angle = |step: i32| f64::from(step) / 60.0 * std::f64::consts::TAU;
    let circle = (0..61).map(|step| [0.7 * angle(step).cos(), 0.7 * angle(step).sin()]);
    for (path, places) in [("turn", turn.collect::<Vec<_>>()), ("circle", circle.collect())] {
        let at = |[turn, nod]: &[f64; 2]| {
            let values: Values = [("turn".to_owned(), *turn), ("nod".to_owned(), *nod)].into();
            drawn(&model, &values)
        };
        let pictures: Vec<Picture> = places.iter().map(at).collect();
        let apart = |pair: &[Picture]| 10f64.powf(-psnr(&pair[0], &pair[1]) / 20.0);
        let mut changes: Vec<f64> = pictures.windows(2).map(apart).collect();
        changes.sort_by(f64::total_cmp);
        let jump = changes[changes.len() - 1] / changes[changes.len() / 2];
        println!("character, {path}: largest change over median {jump:.2}");
        assert!(jump <= JUMP, "{path}: {jump}");
    }
}

#[test]
fn a_character_in_one_layer_is_nearer_than_mixed_pixels() {
    let Some(file) = shared("character-2d/character.json") else { return };
    let mut set = read(&file, None).unwrap();
    set.layers = vec![Layer::whole("all", set.point_len(), Vec::new())];
    set.maps[0].train.iter_mut().for_each(|view| view.layers.clear());
    let all = tested(&set, &made_of(&set).1);
    let [mean, _] = mean_and_worst(&all);
    println!("character in one layer: {mean:.2} dB, {all:.2?}");
    assert!(mean >= FLAT && all.iter().zip(MIXED).all(|(own, mixed)| *own > mixed), "{all:?}");
}

#[test]
fn left_out_views_of_a_head_have_the_right_pictures() {
    let Some(file) = shared("ict-views/views.json") else { return };
    let set = read(&file, None).unwrap();
    let (mut all, mut holes) = (Vec::new(), 0);
    for number in 0..set.maps[0].train.len() {
        let mut rest = set.clone();
        let view = rest.maps[0].train.remove(number);
        let found = drawn(&made_of(&rest).1, &view.values);
        let truth = multiplied(&view.image.as_ref().unwrap().load(set.size).unwrap());
        let seen = view.known().into_iter().zip(&view.visible).filter(|(_, seen)| **seen);
        let hull = hull(&seen.map(|(point, _)| point).collect::<Vec<_>>());
        let mut error = PictureError::default();
        let pixels = found.rgba.chunks(4).zip(truth.rgba.chunks(4)).enumerate();
        for (at, (found, truth)) in pixels {
            let [width, _] = set.size;
            if !is_inside(&hull, [(at % width) as f64 + 0.5, (at / width) as f64 + 0.5]) {
                continue;
            }
            error.add(truth, found);
            holes += usize::from(truth[3] > 127 && found[3] < 128);
        }
        all.push(error.psnr().unwrap());
    }
    let [mean, worst] = mean_and_worst(&all);
    println!("head, each view left out: {mean:.2} dB, worst {worst:.2}, {holes} pixels without");
    assert!(mean >= HEAD[0] && worst >= HEAD[1] && holes <= HOLES, "{all:?} {holes}");
}
