//! Writes OBJ files.

use std::fmt::Write;

/// Writes a mesh as text: positions, texture coordinates, faces.
///
/// - `uv_faces`: which texture coordinate each corner has, as many as `faces`; none without.
pub(crate) fn text(
    positions: &[[f64; 3]],
    uv: &[[f64; 2]],
    faces: &[Vec<usize>],
    uv_faces: &[Vec<usize>],
) -> String {
    let mut out = String::new();
    positions.iter().for_each(|position| push(&mut out, "v", position));
    uv.iter().for_each(|uv| push(&mut out, "vt", uv));
    for (at, face) in faces.iter().enumerate() {
        out.push('f');
        for (corner, vertex) in face.iter().enumerate() {
            let uv = uv_faces.get(at).and_then(|uv| uv.get(corner));
            // Writing to a string cannot fail.
            let _ = match uv {
                Some(uv) => write!(out, " {}/{}", vertex + 1, uv + 1),
                None => write!(out, " {}", vertex + 1),
            };
        }
        out.push('\n');
    }
    out
}

/// Puts other positions into a mesh's text and leaves all else of it as it is.
pub(crate) fn moved(text: &str, positions: &[[f64; 3]]) -> String {
    let mut left = positions.iter();
    let mut out = String::with_capacity(text.len());
    for line in text.lines() {
        match (line.starts_with("v "), left.as_slice().first()) {
            (true, Some(position)) => {
                push(&mut out, "v", position);
                left.next();
            }
            _ => {
                out += line;
                out.push('\n');
            }
        }
    }
    out
}

fn push(out: &mut String, word: &str, numbers: &[f64]) {
    *out += word;
    for number in numbers {
        let _ = write!(out, " {}", *number as f32);
    }
    out.push('\n');
}

#[cfg(test)]
mod tests {
    use super::super::read::parse;
    use super::*;

    #[test]
    fn what_is_written_is_read_again_and_moved_alone() {
        let positions = [[0.0, 0.5, 0.0], [1.0, 0.0, -2.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let (uv, faces) = ([[0.0, 0.25], [1.0, 0.0]], vec![vec![0, 1, 2, 3], vec![2, 1, 0]]);
        let uv_faces = vec![vec![0, 1, 1, 0], vec![1, 1, 1]];
        let text = text(&positions, &uv, &faces, &uv_faces);
        assert!(text.ends_with("f 1/1 2/2 3/2 4/1\nf 3/2 2/2 1/2\n"), "{text}");
        let parsed = parse(text.as_bytes()).unwrap();
        assert_eq!((parsed.positions, parsed.texture), (positions.to_vec(), uv.to_vec()));
        assert!(parsed.polygons.iter().eq(faces.iter().map(Vec::as_slice)));
        let other = positions.map(|position| position.map(|x| x + 0.125));
        let moved = moved(&text, &other);
        assert_eq!(parse(moved.as_bytes()).unwrap().positions, other);
        assert_eq!(
            moved.lines().skip(4).collect::<Vec<_>>(),
            text.lines().skip(4).collect::<Vec<_>>()
        );
    }

    #[test]
    fn faces_without_texture_are_numbers_alone() {
        let text = text(&[[0.0; 3]; 3], &[], &[vec![0, 1, 2]], &[]);
        assert_eq!(text, "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n");
    }
}
