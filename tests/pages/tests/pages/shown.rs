//! The code of the pages, one module per block.
#![expect(dead_code, reason = "it is there to be read, and called in part")]

macro_rules! blocks {
    ($($name:ident: $file:literal,)*) => {
        $(pub(crate) mod $name {
            include!(concat!(env!("OUT_DIR"), "/", $file, ".rs"));
        })*
    };
}

blocks! {
    first: "for_an_engine_0",
    mesh: "your_mesh_0",
    skeleton: "your_skeleton_0",
    curves: "your_curves_0",
    axes: "your_axes_0",
    scale: "scale_0",
    shader: "your_shader_0",
    bones: "your_bones_0",
    vertices: "your_vertices_0",
    shapes: "your_vertices_1",
    face: "your_vertices_2",
    threads: "threads_0",
    crowd: "crowds_and_culling_0",
    crowd_on_threads: "crowds_and_culling_1",
    culling: "crowds_and_culling_2",
    ownership: "ownership_0",
    reload: "hot_reload_0",
    place: "far_from_the_origin_0",
    packed: "packed_vertices_0",
    levels: "levels_of_detail_0",
    seen: "levels_of_detail_1",
    web: "the_module_0",
}
