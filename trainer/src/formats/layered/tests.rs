//! Tests of layered pictures: files of drawing programs, and faulty files.

use super::*;
use crate::formats::pixels::Pixels;
use crate::formats::testing::{Folder, spoil};
use std::io::Write;
use std::path::PathBuf;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// 24 x 16 pixels: a layer "back", and a group "head" of a "face" masked from x = 12, a hidden "eye" and a "mouth".
/// GIMP 2.10 wrote the first two files, Krita 5.1 the other two.
const PICTURES: [&str; 4] = ["gimp.psd", "gimp16.psd", "krita.psd", "krita.ora"];

fn picture(name: &str) -> LayeredPicture {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/views/pictures");
    LayeredPicture::open(&folder.join(name)).unwrap()
}

fn rectangle([left, top, right, bottom]: [usize; 4], colour: [u8; 4]) -> Pixels {
    let inside =
        |at: usize| (left..right).contains(&(at % 24)) && (top..bottom).contains(&(at / 24));
    let pixel = |at| if inside(at) { colour } else { [0; 4] };
    Pixels { size: [24, 16], rgba: (0..24 * 16).flat_map(pixel).collect() }
}

/// Checks that two pictures agree wherever they are not transparent.
fn assert_same(found: &Pixels, expected: &Pixels, what: &str) {
    for (at, (own, other)) in found.rgba.chunks(4).zip(expected.rgba.chunks(4)).enumerate() {
        assert_eq!(own[3], other[3], "{what}: alpha at {}, {}", at % 24, at / 24);
        assert!(own[3] == 0 || own == other, "{what}: {own:?} at {}, {}", at % 24, at / 24);
    }
}

#[test]
fn files_of_drawing_programs_have_their_layers() {
    for name in PICTURES {
        let found = picture(name);
        assert_eq!(found.size, [24, 16]);
        let layers: Vec<_> = found
            .layers
            .iter()
            .map(|own| (own.path.as_str(), (255.0 * own.opacity).round()))
            .collect();
        let expected =
            [("back", 255.0), ("head/face", 255.0), ("head/eye", 0.0), ("head/mouth", 128.0)];
        assert_eq!(layers, expected, "{name}");
        for (layer, area, colour) in [
            ("back", [0, 2, 21, 15], [200, 40, 40, 255]),
            ("head/face", [5, 4, 12, 12], [250, 200, 160, 255]),
            ("eye", [7, 6, 10, 8], [20, 60, 220, 128]),
            ("mouth", [8, 10, 14, 12], [90, 10, 30, 255]),
        ] {
            let own = found.picture(found.find(layer).unwrap()).unwrap();
            assert_same(&own, &rectangle(area, colour), &format!("{name}, {layer}"));
        }
        let whole = found.flattened().unwrap();
        let pixel = |x: usize, y: usize| &whole.rgba[4 * (24 * y + x)..4 * (24 * y + x) + 4];
        assert_eq!(pixel(2, 3), [200, 40, 40, 255], "{name}");
        assert_eq!(pixel(8, 7), [250, 200, 160, 255], "{name}: the eye is hidden");
        // The mouth over the face, at 128 of 255.
        assert_eq!(pixel(9, 10), [170, 105, 95, 255], "{name}");
        assert_eq!(pixel(23, 0), [0; 4], "{name}");
    }
}

#[test]
fn layers_are_found_by_path_or_by_a_name_of_their_own() {
    let found = picture("krita.ora");
    assert_eq!(found.find("head/eye").unwrap(), found.find("eye").unwrap());
    let said = |name| found.find(name).unwrap_err().to_string();
    assert_eq!(said("head"), "\"head\" is a group: merge it, or name its layers");
    assert_eq!(
        said("nose"),
        "has no layer \"nose\": its layers are \"back\", \"head/face\", \"head/eye\", \"head/mouth\""
    );
}

/// Writes an OpenRaster file.
fn ora(folder: &Folder, entries: &[(&str, &[u8])]) -> PathBuf {
    let path = folder.0.join("made.ora");
    let mut zip = ZipWriter::new(File::create(&path).unwrap());
    for (name, bytes) in entries {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap();
    path
}

fn stack(layers: &str) -> Vec<u8> {
    format!("<image w=\"24\" h=\"16\"><stack>{layers}</stack></image>").into_bytes()
}

#[test]
fn open_raster_files_with_faults_are_refused() {
    let folder = Folder::new("layered-ora");
    let said = |entries: &[(&str, &[u8])]| {
        let opened = LayeredPicture::open(&ora(&folder, entries));
        let found =
            opened.and_then(|own| own.picture(0).map_err(|error| error.in_file("made.ora")));
        let text = found.unwrap_err().to_string();
        text.rsplit_once("made.ora: ").unwrap().1.to_owned()
    };
    let list = |text: &str| said(&[("stack.xml", &stack(text))]);
    assert_eq!(said(&[("a.png", b"")]), "has no stack.xml: expected an OpenRaster file");
    assert!(said(&[("stack.xml", b"<image")]).starts_with("stack.xml: "));
    assert_eq!(said(&[("stack.xml", b"<image w='3'/>")]), "stack.xml: image: expected w and h");
    assert_eq!(
        said(&[("stack.xml", b"<image w='99999' h='99999'><stack/></image>")]),
        "is too large: 99999 x 99999 pixels, expected at most 67108864 in all"
    );
    assert_eq!(list("<layer name='a'/>"), "stack.xml: a: it has no src");
    assert_eq!(
        list("<layer name='a' src='a.png' x='left'/>"),
        "stack.xml: a: x is \"left\", expected a number"
    );
    assert_eq!(
        list("<layer name='a' src='a.png'/>"),
        "layer \"a\": has no a.png: expected an OpenRaster file"
    );
    assert_eq!(
        list("<layer name='a' src='a.png' composite-op='svg:multiply'/>"),
        "layer \"a\" has the blend mode svg:multiply, expected normal: merge it down"
    );
    assert_eq!(
        list("<layer name='a' src='a.png'/><layer name='a' src='b.png'/>"),
        "has two layers \"a\": give each its own name"
    );
    assert_eq!(
        list(
            "<layer name='a' src='' composite-op='svg:src-atop'/><layer name='b' src=''/><layer name='c' src=''/>"
        ),
        "layer \"a\" is clipped to all of 2 layers below it, expected one layer below it in its group"
    );
    assert!(list(&"<stack>".repeat(70)).starts_with("stack.xml: "), "unclosed");
    let deep = ["<stack>".repeat(70), "</stack>".repeat(70)].concat();
    assert_eq!(list(&deep), "stack.xml: groups within groups, more than 64 deep");
    // Entities that expand exponentially.
    let bomb =
        "<!DOCTYPE a [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;\">]><image>&b;</image>";
    assert!(said(&[("stack.xml", bomb.as_bytes())]).contains("DTD"));
    let spaces = stack(&"<layer xmlns:a='b'/>".repeat(65));
    let found = said(&[("stack.xml", &spaces)]);
    assert_eq!(found, "is too large: stack.xml: 65 namespaces, expected at most 64");
    let long = vec![b' '; (1 << 19) + 1];
    let found = said(&[("stack.xml", &long)]);
    assert_eq!(found, "is too large: stack.xml, expected at most 524288 bytes");
    // A picture that claims to be larger than memory.
    let mut png =
        b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\x7f\xff\xff\xff\x7f\xff\xff\xff\x08\x06\0\0\0".to_vec();
    png.extend(crc(&png[12..]).to_be_bytes());
    let found = said(&[("stack.xml", &stack("<layer name='a' src='a.png'/>")), ("a.png", &png)]);
    assert!(found.starts_with("layer \"a\": a.png: "), "{found}");
    let found =
        LayeredPicture::open(&folder.write("made.ora", "no archive")).err().unwrap().to_string();
    assert!(found.contains("expected an OpenRaster file, which is a zip archive"), "{found}");
}

fn crc(bytes: &[u8]) -> u32 {
    crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(bytes)
}

/// A layer of a PSD file: name, opacity and clipping flag, kind of section, blend mode.
type Row<'a> = (&'a str, [u8; 2], u32, &'a [u8; 4]);

/// Returns a PSD file of 2 x 1 pixels with grey layers.
fn psd(depth: u16, mode: u16, rows: &[Row<'_>]) -> Vec<u8> {
    let mut layers = (rows.len() as i16).to_be_bytes().to_vec();
    for (name, [opacity, clipping], section, blend) in rows {
        let words =
            |words: &[u32]| words.iter().flat_map(|word| word.to_be_bytes()).collect::<Vec<_>>();
        layers.extend(words(&[0, 0, 1, 2]));
        layers.extend(2u16.to_be_bytes());
        for id in [0i16, -1] {
            layers.extend(id.to_be_bytes());
            layers.extend(4u32.to_be_bytes());
        }
        layers.extend(b"8BIM");
        layers.extend(*blend);
        layers.extend([*opacity, *clipping, 0, 0]);
        let mut extra = words(&[0, 0]);
        extra.push(name.len() as u8);
        extra.extend(name.bytes());
        extra.resize(8 + (name.len() + 1).next_multiple_of(4), 0);
        extra.extend(b"8BIMlsct");
        extra.extend(words(&[4, *section]));
        layers.extend((extra.len() as u32).to_be_bytes());
        layers.extend(extra);
    }
    layers.extend([0, 0, 9, 8].repeat(2 * rows.len()));
    let mut out = b"8BPS\0\x01\0\0\0\0\0\0\0\x01\0\0\0\x01\0\0\0\x02".to_vec();
    out.extend(depth.to_be_bytes());
    out.extend(mode.to_be_bytes());
    out.extend([0; 8]);
    out.extend((layers.len() as u32 + 4).to_be_bytes());
    out.extend((layers.len() as u32).to_be_bytes());
    out.extend(layers);
    out
}

#[test]
fn clipped_layers_of_photoshop_files_name_their_base() {
    let folder = Folder::new("layered-clip");
    let rows: [Row<'_>; 6] = [
        ("skin", [255, 0], 0, b"norm"),
        ("", [255, 0], 3, b"norm"),
        ("shade", [255, 0], 0, b"norm"),
        ("light", [255, 0], 0, b"mul "),
        ("on skin", [255, 1], 1, b"pass"),
        ("line", [255, 1], 0, b"norm"),
    ];
    let path = folder.write("made.psd", psd(8, 1, &rows));
    let found = LayeredPicture::open(&path).unwrap();
    let clips: Vec<_> = found.layers.iter().map(|own| (own.path.as_str(), own.clip)).collect();
    let expected =
        [("skin", None), ("on skin/shade", Some(0)), ("on skin/light", Some(0)), ("line", Some(0))];
    assert_eq!(clips, expected);
    assert_eq!(found.picture(0).unwrap().rgba, [9, 9, 9, 9, 8, 8, 8, 8]);
    let refused = found.picture(2).unwrap_err().to_string();
    assert_eq!(
        refused,
        "layer \"on skin/light\" has the blend mode mul, expected normal: merge it down"
    );
}

#[test]
fn a_clipped_layer_is_as_opaque_as_its_base() {
    let folder = Folder::new("layered-opacity");
    let rows: [Row<'_>; 2] = [("skin", [102, 0], 0, b"norm"), ("line", [255, 1], 0, b"norm")];
    let mut bytes = psd(8, 1, &rows);
    // Sets every sample to 255.
    let channels = bytes.len() - 4 * 2 * rows.len();
    bytes[channels..].chunks_mut(4).for_each(|channel| channel[2..].fill(255));
    let path = folder.write("made.psd", bytes);
    let whole = LayeredPicture::open(&path).unwrap().flattened().unwrap();
    // 102 of 255 over 102 of 255.
    assert_eq!(whole.rgba[3], 163);
}

#[test]
fn layers_with_effects_are_refused() {
    let folder = Folder::new("layered-unread");
    let rows: [Row<'_>; 1] = [("a", [255, 0], 0, b"norm")];
    for (key, what) in
        [(b"lfx2", "a layer style"), (b"vmsk", "a vector mask"), (b"curv", "an adjustment")]
    {
        let mut bytes = psd(8, 1, &rows);
        let at = bytes.windows(4).position(|own| own == b"lsct").unwrap();
        bytes[at..at + 4].copy_from_slice(key);
        let found = LayeredPicture::open(&folder.write("made.psd", bytes)).unwrap();
        assert_eq!(
            found.picture(0).unwrap_err().to_string(),
            format!("layer \"a\": \"a\" has {what}, expected pixels: rasterise or merge it")
        );
    }
}

#[test]
fn photoshop_files_without_layers_are_refused() {
    let folder = Folder::new("layered-flat");
    let whole = psd(8, 1, &[]);
    // The length of the layer section, then the length of the layers.
    let at = whole.len() - 2 - 8;
    let flat = [&whole[..at], &[0; 4]].concat();
    let empty = [&whole[..at], &[0, 0, 0, 8], &[0; 8]].concat();
    let short = [&whole[..at], &[0, 0, 0, 4], &[0; 4]].concat();
    for bytes in [whole, flat, empty, short] {
        let said =
            LayeredPicture::open(&folder.write("made.psd", bytes)).err().unwrap().to_string();
        assert!(said.ends_with("has no layers: save it with layers, or save a PNG"), "{said}");
    }
}

#[test]
fn photoshop_files_of_other_kinds_are_refused() {
    let said = |bytes: Vec<u8>| psd::Document::read(bytes).err().unwrap().to_string();
    let one: [Row<'_>; 1] = [("a", [255, 0], 0, b"norm")];
    assert_eq!(said(b"BM".to_vec()), "expected a Photoshop file, which begins with 8BPS");
    assert_eq!(
        said(psd(8, 4, &one)),
        "has colour mode 4 (CMYK), expected RGB or greyscale: convert it and save it again"
    );
    assert_eq!(
        said(psd(32, 3, &one)),
        "has 32 bits a channel, expected 8 or 16: convert it and save it again"
    );
    let mut large = psd(8, 3, &one);
    large[5] = 2;
    assert!(said(large).contains("version 2 (PSB)"));
    let mut large = psd(8, 3, &one);
    large[14..22].fill(0x7f);
    assert!(said(large).starts_with("is too large: "));
    for (rows, what) in [
        (&[("a", [255, 0], 3, b"norm")][..], "is damaged: a group has no end"),
        (&[("a", [255, 0], 1, b"norm")], "is damaged: group \"a\" has no beginning"),
    ] {
        assert_eq!(said(psd(8, 3, rows)), what);
    }
}

#[test]
fn no_bytes_of_a_photoshop_file_make_the_reader_panic() {
    let rows: [Row<'_>; 3] =
        [("", [255, 0], 3, b"norm"), ("a", [255, 0], 0, b"norm"), ("group", [255, 0], 1, b"pass")];
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/views/pictures");
    for whole in [psd(8, 1, &rows), std::fs::read(folder.join("gimp16.psd")).unwrap()] {
        spoil(&whole, |bytes| {
            let Ok((document, size, nodes)) = psd::Document::read(bytes.to_vec()) else { return };
            let Ok((layers, groups)) = tree::list_layers(nodes) else { return };
            // Sizes are bounded, but large pictures take too long.
            if size[0] * size[1] > 1 << 12 {
                return;
            }
            let opened = LayeredPicture { size, layers, groups, content: Content::Psd(document) };
            for layer in 0..opened.layers.len() {
                let _ = opened.picture(layer);
            }
        });
    }
}
