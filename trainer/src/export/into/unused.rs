//! What is left of a file's arrays when others have taken their place.

use serde_json::Value;

use crate::formats::gltf::write::Document;

impl Document {
    /// Makes room of arrays that nothing uses any more, and of the views that they alone used; their
    /// bytes stay.
    pub(super) fn free_unused(&mut self, arrays: impl IntoIterator<Item = usize>) {
        let mut used = vec![0_usize; self.accessors.len()];
        let primitives = self.meshes.iter().flat_map(|mesh| list(mesh, "primitives"));
        let in_primitives = primitives.flat_map(|primitive| {
            let targets = list(primitive, "targets").flat_map(members);
            let attributes = primitive.get("attributes").into_iter().flat_map(members);
            attributes.chain(targets).chain(primitive.get("indices"))
        });
        let in_skins = self.skins.iter().filter_map(|skin| skin.get("inverseBindMatrices"));
        let samplers = self.animations.iter().flat_map(|animation| list(animation, "samplers"));
        let in_samplers =
            samplers.flat_map(|sampler| [sampler.get("input"), sampler.get("output")]).flatten();
        count(in_primitives.chain(in_skins).chain(in_samplers), &mut used);
        let mut arrays: Vec<usize> = arrays.into_iter().filter(|&array| used[array] == 0).collect();
        arrays.sort_unstable();
        arrays.dedup();
        let views = |array: &Value| -> Vec<usize> {
            let sparse = array.get("sparse");
            let parts = ["indices", "values"].map(|part| sparse.and_then(|s| s.get(part)));
            let all = parts.into_iter().flatten().chain([array]);
            let views = all.filter_map(|part| Some(part.get("bufferView")?.as_u64()? as usize));
            views.collect()
        };
        let mut free: Vec<usize> =
            arrays.iter().flat_map(|&array| views(&self.accessors[array])).collect();
        free.sort_unstable();
        free.dedup();
        let kept = (0..self.accessors.len()).filter(|array| arrays.binary_search(array).is_err());
        let kept: Vec<usize> = kept.flat_map(|array| views(&self.accessors[array])).collect();
        free.retain(|view| !kept.contains(view));
        // The first are filled first.
        arrays.reverse();
        free.reverse();
        self.free = [arrays, free];
    }
}

fn list<'a>(value: &'a Value, name: &str) -> impl Iterator<Item = &'a Value> {
    value.get(name).and_then(Value::as_array).into_iter().flatten()
}

fn members(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_object().into_iter().flat_map(|members| members.values())
}

fn count<'a>(numbers: impl Iterator<Item = &'a Value>, used: &mut [usize]) {
    for number in numbers.filter_map(Value::as_u64) {
        if let Some(used) = used.get_mut(number as usize) {
            *used += 1;
        }
    }
}
