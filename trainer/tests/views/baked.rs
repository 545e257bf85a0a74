//! Sets in model files, drawn by the runtime.

use super::common::{Folder, apart, head, most};
use sinew_runtime::Model;
use sinew_runtime::format::Space;
use sinew_trainer::bake::bake;
use sinew_trainer::page::picture::Picture;
use sinew_trainer::views::demo::write;
use sinew_trainer::views::evaluate::evaluate;
use sinew_trainer::views::fit::FitOptions;
use sinew_trainer::views::inverse::starts;
use sinew_trainer::views::model::parts;
use sinew_trainer::views::object::{ObjectMap, centred};
use sinew_trainer::views::player::{Player, multiplied};
use sinew_trainer::views::set::{Image, Values, View, ViewSet, read};
use sinew_trainer::views::train::{Trained, train};
use sinew_trainer::views::transfer::transfer;

/// Tolerance of points in single precision, pixels.
const RUNTIME: f64 = 1e-3;

fn file(trained: &Trained) -> Model<Vec<u8>> {
    Model::from_bytes(bake(Space::default(), &parts(&trained.model).unwrap()).unwrap()).unwrap()
}

fn trained(set: &ViewSet) -> (Trained, Model<Vec<u8>>) {
    let trained = train(set, FitOptions::default()).unwrap();
    let file = file(&trained);
    (trained, file)
}

/// Returns the largest difference of two pictures in a byte.
fn differ(a: &Picture, b: &Picture) -> u8 {
    assert_eq!(a.size, b.size);
    a.rgba.iter().zip(&b.rgba).map(|(a, b)| a.abs_diff(*b)).max().unwrap()
}

#[test]
fn the_run_time_shows_what_was_trained() {
    let folder = Folder::new("baked");
    let written = write(&folder.path("")).unwrap();
    let again = |set: &ViewSet| read(&folder.path(&set.name).join("views.json"), None).unwrap();
    let mut sets: Vec<ViewSet> = written.iter().map(again).collect();
    sets.extend(head());
    for set in sets {
        let (trained, file) = trained(&set);
        let outputs = trained.model.outputs();
        let mut worst = 0.0f64;
        for (examples, map) in set.maps.iter().zip(&trained.model.maps) {
            for pair in examples.train.windows(2) {
                let share =
                    |name: &String, a: &f64| (name.clone(), 0.7 * a + 0.3 * pair[1].values[name]);
                let values: Values =
                    pair[0].values.iter().map(|(name, a)| share(name, a)).collect();
                let expected = outputs.evaluate(map, &values).unwrap();
                let player = Player::new(&file, Some(&examples.name)).unwrap();
                let found = player.play(&values).unwrap();
                let places: Vec<[f64; 2]> =
                    found.points.iter().map(|[x, y, _]| [f64::from(*x), f64::from(*y)]).collect();
                worst = worst.max(most(&apart(&places, &expected.points)));
                assert_eq!(Some(found.view), expected.view(), "{}: {values:?}", set.name);
                for (found, depth) in found.points.iter().zip(&expected.depths) {
                    assert!((f64::from(found[2]) - depth).abs() < 10.0 * RUNTIME);
                }
            }
        }
        println!("{}: {} bytes, {worst:.1e} px", set.name, file.as_bytes().len());
        assert!(worst < RUNTIME, "{}: {worst}", set.name);
    }
}

#[test]
fn key_views_reproduce_their_pictures_inside_elements() {
    let Some(set) = head() else { return };
    let (trained, file) = trained(&set);
    for (view, key) in set.maps[0].train.iter().zip(&trained.model.keys) {
        let own = multiplied(&view.image.as_ref().unwrap().load(set.size).unwrap());
        let player = Player::new(&file, None).unwrap();
        let played = player.play(&view.values).unwrap();
        let (picture, drawn) = player.draw(&played).unwrap();
        assert!(drawn.element_len > 150 && drawn.flipped_len == 0, "{drawn:?}");
        // The border of the picture is translucent.
        let whole = |(a, _): &(&[u8], &[u8])| a[3] == 255;
        let pixels = || picture.rgba.chunks(4).zip(own.rgba.chunks(4)).filter(whole);
        let apart = pixels().flat_map(|(a, b)| a.iter().zip(b)).map(|(a, b)| a.abs_diff(*b));
        assert!(pixels().count() > 8000 && apart.max() <= Some(1), "{}", key.name);
    }
}

#[test]
fn points_drive_an_object_like_its_parameters() {
    let Some(set) = head() else { return };
    let (_, file) = trained(&set);
    let object = ObjectMap::new(&Player::new(&file, None).unwrap());
    let starts = starts(&object.model);
    for (number, view) in set.maps[0].train.iter().enumerate() {
        let points: Vec<_> = (0..158).map(|k| view.points[k].filter(|_| view.visible[k])).collect();
        let found = object.find(&points, &starts).unwrap();
        let shown = |values: &Values| {
            let player = Player::new(&file, None).unwrap();
            let played = player.play(values).unwrap();
            (played.view, player.draw(&played).unwrap().0)
        };
        let ((a, own), (b, driven)) = (shown(&view.values), shown(&found.values));
        assert_eq!((a, b), (number, number));
        let off = differ(&own, &driven);
        assert!(off <= 1, "view {number}: {off}, {:?}", found.values);
    }
}

#[test]
fn figures_of_a_file_hold_for_its_training_views() {
    let Some(set) = head() else { return };
    let (_, file) = trained(&set);
    let found = evaluate(&file, &set).unwrap();
    println!("{found:?}");
    assert_eq!(found.views, 27);
    let points = found.points.unwrap();
    assert!(points.rms < 0.001 && points.max < 0.005 && points.visibility > 0.99, "{points:?}");
    assert!(found.psnr_opaque.is_none_or(|psnr| psnr > 30.0) && found.flipped == 0);
}

#[test]
fn an_instance_moves_as_its_prototype_does() {
    let folder = Folder::new("instance");
    let figure = write(&folder.path("")).unwrap().remove(0);
    let (_, prototype) = trained(&figure);
    let (map, number) = figure.key_views()[0];
    let rest = &figure.maps[map].train[number];
    // A wider sister, drawn on the same sheet.
    let wider = |[x, y]: [f64; 2]| [120.0 + 1.25 * (x - 120.0), 10.0 + 0.9 * y];
    let instance = View {
        points: rest.known().into_iter().map(|point| Some(wider(point))).collect(),
        ..rest.clone()
    };
    let place = |played: &[[f32; 3]]| -> Vec<[f64; 2]> {
        played.iter().map(|[x, y, _]| [f64::from(*x), f64::from(*y)]).collect()
    };
    for by_size in [false, true] {
        let named = vec![("texture".to_owned(), instance.clone())];
        let made = transfer(&prototype, "sister", &named, by_size).unwrap();
        let deformation = made.keys[0].deformation.clone().unwrap();
        let made =
            Model::from_bytes(bake(Space::default(), &parts(&made).unwrap()).unwrap()).unwrap();
        for examples in &figure.maps {
            for view in &examples.train {
                let of = |file| {
                    let player = Player::new(file, Some(&examples.name)).unwrap();
                    place(&player.play(&view.values).unwrap().points)
                };
                let (own, centre) = centred(&of(&prototype));
                let point = |(own, offset): (&[f64; 2], &[f64; 2])| {
                    [0, 1].map(|axis| deformation.scale * own[axis] + offset[axis] + centre[axis])
                };
                let expected: Vec<_> = own.iter().zip(&deformation.offsets).map(point).collect();
                let off = most(&apart(&of(&made), &expected));
                assert!(off < RUNTIME, "{}: {off}", examples.name);
            }
        }
    }
    let wrong = |view: &str, own: View| {
        transfer(&prototype, "x", &[(view.to_owned(), own)], false).unwrap_err().to_string()
    };
    let refused = wrong("side", instance.clone());
    assert_eq!(refused, "view \"side\" of the instance: no key view; the prototype's are texture");
    let mut short = instance.clone();
    short.points.pop();
    assert!(wrong("texture", short).contains("points, found"));
    let mut hole = instance.clone();
    hole.points[7] = None;
    assert!(wrong("texture", hole).ends_with("point 7 has no place"));
    let bare = View { image: None::<Image>, ..instance };
    assert_eq!(wrong("texture", bare), "there are no pictures");
}
