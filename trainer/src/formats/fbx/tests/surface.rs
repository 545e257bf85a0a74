//! Tests of normals, tangents and texture coordinates by corner.

use super::*;

#[test]
fn a_seam_splits_only_the_engine_s_vertices() {
    let texture = |indices: &str| {
        format!(
            "LayerElementUV: 0 {{\nMappingInformationType: \"ByPolygonVertex\"\n\
             ReferenceInformationType: \"IndexToDirect\"\nUV: *12 {{\na: 0,0,1,0,1,1,0,1,0.5,0.5,2,2\n}}\n\
             UVIndex: *7 {{\na: {indices}\n}}\n}}\nLayer: 0 {{\nLayerElement: {{\n\
             Type: \"LayerElementUV\"\nTypedIndex: 0\n}}\n}}\n"
        )
    };
    let with = |indices| {
        let mut arm = Arm::bare();
        let node = arm.scene.node("textured", "Mesh", 0, &[]);
        let mesh = arm.scene.mesh(node, &ARM, &FACES, &texture(indices));
        arm.bind(mesh, "Linear");
        arm.rig()
    };
    let uv = vec![[0.0, 0.0], [1.0, 0.0], [2.0, 2.0], [1.0, 1.0], [0.0, 1.0]];
    let whole = with("0,1,2,3,1,5,2").engine.unwrap();
    assert!(whole.is_one_each());
    assert_eq!(whole.uv, Some(uv));
    let seam = with("0,1,2,3,1,5,4");
    assert_eq!((seam.rest.len(), seam.warnings.len()), (5, 1));
    let engine = seam.engine.unwrap();
    // At vertex 1 the coordinates agree. The tangents differ there, because the seam starts at vertex 1.
    assert_eq!(engine.copy_of, [0, 1, 1, 2, 3, 3, 4]);
    assert_eq!(engine.triangles, [[0, 1, 4], [0, 4, 6], [2, 3, 5]]);
    assert_eq!(engine.uv.unwrap()[4..6], [[1.0, 1.0], [0.5, 0.5]]);
}

/// Normals by corner: those of the triangle lean, and the last one has no direction.
#[test]
fn normals_by_corner_go_where_the_mesh_is_bound() {
    let (up, lean) = ("0,0,2", "0.6,0,0.8");
    let normals = format!(
        "LayerElementNormal: 0 {{\nMappingInformationType: \"ByPolygonVertex\"\n\
         ReferenceInformationType: \"Direct\"\nNormals: *21 {{\na: {up},{up},{up},{up},{lean},{lean},0,0,0\n}}\n}}\n\
         Layer: 0 {{\nLayerElement: {{\nType: \"LayerElementNormal\"\nTypedIndex: 0\n}}\n}}\n"
    );
    let mut scene = Scene::default();
    let tip = scene.node("tip", "LimbNode", 0, &[]);
    // Mirrored and stretched along x, which shrinks a normal's x component.
    let node = scene.node("mirrored", "Mesh", 0, &[("Lcl Scaling", [-2.0, 1.0, 1.0])]);
    scene.mesh(node, &ARM, &FACES, &normals);
    let layer = scene.animation("bend");
    scene.keys(layer, tip, "Lcl Rotation", "d|Z", &[(1, 0.0), (2, 90.0)]);
    let rig = parse(scene.text().as_bytes(), &KEYS).unwrap();
    assert_eq!(rig.warnings, [FormatWarning::NormalsRepaired(1)]);
    let engine = rig.engine.unwrap();
    assert_eq!(engine.copy_of, [0, 1, 1, 2, 3, 4]);
    assert_eq!(engine.triangles, [[0, 4, 1], [0, 5, 4], [2, 4, 3]]);
    let leaning = nalgebra::Vector3::new(-0.3, 0.0, 0.8).normalize().into();
    let up = [0.0, 0.0, 1.0];
    near(&engine.normals.unwrap(), &[up, up, leaning, leaning, up, up]);
}

/// Writes a layer of directions by corner, the direction `of` each corner.
fn layer(kind: &str, array: &str, of: &str) -> String {
    let numbers = [of; 7].join(",");
    format!(
        "LayerElement{kind}: 0 {{\nMappingInformationType: \"ByPolygonVertex\"\n\
         ReferenceInformationType: \"Direct\"\n{array}: *21 {{\na: {numbers}\n}}\n}}\n"
    )
}

#[test]
fn tangents_keep_the_sides_of_the_texture_under_a_mirror() {
    // u grows along x, v along y.
    let layers = layer("Normal", "Normals", "0,0,1")
        + &layer("Tangent", "Tangents", "1,0,0")
        + &layer("Binormal", "Binormals", "0,1,0")
        + "LayerElementUV: 0 {\nMappingInformationType: \"ByVertice\"\nReferenceInformationType: \"Direct\"\n\
           UV: *10 {\na: 0,0,1,0,2,0,2,1,0,1\n}\n}\n";
    let kinds = ["Normal", "Tangent", "Binormal", "UV"]
        .map(|kind| format!("LayerElement: {{\nType: \"LayerElement{kind}\"\nTypedIndex: 0\n}}\n"));
    let layers = format!("{layers}Layer: 0 {{\nVersion: 100\n{}}}\n", kinds.concat());
    for x in [1.0, -1.0] {
        let mut scene = Scene::default();
        let tip = scene.node("tip", "LimbNode", 0, &[]);
        let node = scene.node("body", "Mesh", 0, &[("Lcl Scaling", [x, 1.0, 1.0])]);
        scene.mesh(node, &ARM, &FACES, &layers);
        let animation = scene.animation("bend");
        scene.keys(animation, tip, "Lcl Rotation", "d|Z", &[(1, 0.0), (2, 90.0)]);
        let engine = parse(scene.text().as_bytes(), &KEYS).unwrap().engine.unwrap();
        assert_eq!(engine.normals.unwrap(), [[0.0, 0.0, 1.0]; 5]);
        // v still grows along y, which is the handedness times normal x tangent.
        assert_eq!(engine.tangents.unwrap(), [[x, 0.0, 0.0, x]; 5]);
    }
}
