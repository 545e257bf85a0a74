use super::*;

#[test]
fn write_for_tuning() {
    let v = std::env::var("DEMO_V").map_or(1000, |v| v.parse().unwrap());
    let e = demo(&DemoOptions { vertices: v, ..DemoOptions::default() });
    crate::examples::npz::save_npz(std::path::Path::new("/tmp/demo.npz"), &e).unwrap();
}
