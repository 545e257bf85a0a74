//! Objects in layers as Inochi2D puppets.

use super::common::Folder;
use super::flat::{SCREEN, Sheet, draw, drawn, in_layers, made, mean_and_worst, psnr};
use super::puppets::posed;
use inochi2d_parser::prelude::Puppet;
use models::shared;
use sinew_runtime::Model;
use sinew_trainer::page::picture::Picture;
use sinew_trainer::views::export::{Grid, Side, puppet};
use sinew_trainer::views::set::Values;

fn exported(file: &Model<Vec<u8>>, sides: &[(&str, usize)]) -> (Grid, Puppet) {
    let side = |(name, nodes): &(&str, usize)| Side {
        name: (*name).to_owned(),
        range: None,
        nodes: *nodes,
    };
    let sides: Vec<Side> = sides.iter().map(side).collect();
    let grid = Grid::of_sides(file, None, &Values::new(), &sides).unwrap();
    let puppet = Puppet::from_bytes(&puppet(file, None, &grid).unwrap()).unwrap();
    (grid, puppet)
}

#[test]
fn layers_fade_change_their_order_and_are_masked_in_a_puppet() {
    let folder = Folder::new("puppet-layers");
    let (_, file) = made(&in_layers(&folder));
    let (grid, puppet) = exported(&file, &[("x", 5)]);
    assert_eq!(posed(&puppet, SCREEN, [0.0; 2]).sheets.len(), 8, "a layer and key view each");
    for (node, shown) in grid.nodes.iter().enumerate() {
        let pose = posed(&puppet, SCREEN, [node as f64, 0.0]);
        let found = draw(SCREEN, &pose.sheets, &pose.order);
        let expected = drawn(&file, &shown.values);
        // The mask has a hard edge, and few pixels are half covered.
        let psnr = psnr(&found, &expected);
        println!("puppet in layers, x = {}: {psnr:.2} dB", shown.values["x"]);
        assert!(psnr > 34.0, "{node}: {psnr}");
        // Back, face, eye, clipped part of the eye, arm: inside, the colours equal the runtime's blend.
        let x = shown.values["x"];
        for place in [[12.0, 12.0], [40.0, 30.0], [62.0, 44.0], [76.0, 44.0], [20.0, 60.0]] {
            let at = [place[0] + 4.0 * x, place[1]].map(|x| x as usize);
            let pixel = |own: &Picture| {
                let at = 4 * (at[1] * SCREEN[0] + at[0]);
                [0, 1, 2, 3].map(|k| own.rgba[at + k])
            };
            let (found, expected) = (pixel(&found), pixel(&expected));
            let apart = found.iter().zip(expected).map(|(a, b)| a.abs_diff(b)).max().unwrap();
            assert!(apart <= 2, "x = {x}, {place:?}: {found:?} {expected:?}");
        }
        // The order of the arm is 0.5 + 2.5 x. The order of the other layers is their index.
        let names: Vec<&str> = pose.order.iter().map(|&at| pose.names[at].as_str()).collect();
        let layer = |at: usize| names[at].split(' ').next().unwrap();
        let arm = ["back", "arm", "face", "eye"];
        let expected = match 0.5 + 2.5 * x {
            order if order < 1.0 => arm,
            order if order < 2.0 => ["back", "face", "arm", "eye"],
            _ => ["back", "face", "eye", "arm"],
        };
        assert_eq!([0, 2, 4, 6].map(layer), expected, "x = {x}");
        assert_eq!([1, 3, 5, 7].map(layer), expected, "x = {x}");
        // Without masks, or in another order, the picture differs.
        let mut bare = pose.sheets.clone();
        bare.iter_mut().for_each(|sheet| sheet.masks.clear());
        assert!(psnr_of(&bare, &pose.order, &drawn(&file, &shown.values)) < psnr - 1.0);
        let turned: Vec<usize> = pose.order.iter().rev().copied().collect();
        assert!(psnr_of(&pose.sheets, &turned, &drawn(&file, &shown.values)) < 20.0);
    }
    // The background stays hidden between nodes, too.
    for step in 0..=16 {
        let pose = posed(&puppet, SCREEN, [f64::from(step) / 4.0, 0.0]);
        let found = draw(SCREEN, &pose.sheets, &pose.order);
        for [x, y] in [[16, 16], [40, 40]] {
            assert_eq!(found.rgba[4 * (y * SCREEN[0] + x) + 3], 255, "step {step}");
        }
    }
}

fn psnr_of(sheets: &[Sheet], order: &[usize], expected: &Picture) -> f64 {
    psnr(&draw(SCREEN, sheets, order), expected)
}

#[test]
fn a_character_s_puppet_is_what_the_model_draws() {
    let Some(set) = shared("character-2d/character.json") else { return };
    let (_, file) = made(&set);
    let (grid, puppet) = exported(&file, &[("turn", 5), ("nod", 5)]);
    let mut all = Vec::new();
    for (node, shown) in grid.nodes.iter().enumerate() {
        let pose = posed(&puppet, [320, 320], [(node / 5) as f64, (node % 5) as f64]);
        let found = draw([320, 320], &pose.sheets, &pose.order);
        let expected = drawn(&file, &shown.values);
        all.push(psnr(&found, &expected));
    }
    let [mean, worst] = mean_and_worst(&all);
    println!("puppet of the character over the model, 25 nodes: {mean:.2} dB, worst {worst:.2}");
    // Halfway between nodes.
    let mut between = Vec::new();
    for node in 0..4 {
        let way = -0.75 + 0.5 * f64::from(node);
        let pose = posed(&puppet, [320, 320], [f64::from(node) + 0.5, f64::from(node) + 0.5]);
        let values = [("turn".to_owned(), way), ("nod".to_owned(), way)].into();
        let found = draw([320, 320], &pose.sheets, &pose.order);
        between.push(psnr(&found, &drawn(&file, &values)));
    }
    println!("between nodes: {between:.2?}");
    assert!(mean > 36.0 && worst > 31.0, "{all:?}");
    assert!(between.iter().all(|psnr| *psnr > 32.0), "{between:?}");
}
