"""Writes example poses of a rigged character, for `sinew train`.

Whatever Blender shows is what is written: muscles, correctives, simulation, any modifier that keeps
the mesh's vertices. For each frame it evaluates the mesh and the bones that deform it, in world
space.

    blender rig.blend --background --python blender_export.py -- examples.npz
    python blender_export.py --blend rig.blend examples.npz        (with `pip install bpy`)

Options: --mesh NAME, --armature NAME (needed where there are several), --frames FIRST:LAST[:STEP]
(the scene's own range otherwise), --bones all (the deforming ones otherwise).
"""

import argparse
import sys
from pathlib import Path

import bpy
import numpy as np


class Problem(Exception):
    """Something about the scene that the user can mend."""


def main(arguments):
    options = parse(arguments)
    if options.blend:
        bpy.ops.wm.open_mainfile(filepath=str(options.blend))
    scene = bpy.context.scene
    mesh, armature = find(scene, options)
    bones = deforming(armature, options.bones)
    frames = frame_numbers(scene, options.frames)
    examples = {**faces_and_rest(scene, mesh, armature), **skeleton(armature, bones)}
    examples.update(poses(scene, mesh, armature, bones, frames, len(examples["rest"])))
    # The last name decides the format: numpy would add .npz to any other.
    with open(options.output, "wb") as file:
        np.savez_compressed(file, **examples)
    print(
        f"wrote {options.output}: {len(examples['rest'])} vertices, {len(bones)} joints, "
        f"{len(frames)} frames"
    )


def parse(arguments):
    parser = argparse.ArgumentParser(prog="blender_export.py", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=Path, help="where to write the examples (.npz)")
    parser.add_argument("--blend", type=Path, help="the file to open, outside of Blender")
    parser.add_argument("--mesh", help="the mesh object")
    parser.add_argument("--armature", help="the armature object")
    parser.add_argument("--frames", help="FIRST:LAST or FIRST:LAST:STEP")
    parser.add_argument("--bones", choices=["deforming", "all"], default="deforming")
    options = parser.parse_args(arguments)
    if options.output.suffix != ".npz":
        parser.error(f"{options.output}: expected a name that ends in .npz")
    return options


def find(scene, options):
    """Gives the mesh and the armature that deforms it."""
    armature = options.armature and named(scene, options.armature, "ARMATURE")
    if options.mesh:
        mesh = named(scene, options.mesh, "MESH")
    else:
        meshes = [o for o in scene.objects if o.type == "MESH" and armature_of(o)]
        meshes = [o for o in meshes if armature in (None, armature_of(o))]
        if len(meshes) != 1:
            found = ", ".join(o.name for o in meshes) or "none"
            raise Problem(f"expected one mesh with an armature, found {found}: give --mesh NAME")
        mesh = meshes[0]
    armature = armature or armature_of(mesh)
    if armature is None:
        raise Problem(f"mesh {mesh.name} has no armature: give --armature NAME")
    return mesh, armature


def named(scene, name, kind):
    thing = scene.objects.get(name)
    if thing is None or thing.type != kind:
        known = ", ".join(o.name for o in scene.objects if o.type == kind) or "none"
        raise Problem(f"there is no {kind.lower()} {name}, only: {known}")
    return thing


def armature_of(mesh):
    modifiers = [m.object for m in mesh.modifiers if m.type == "ARMATURE" and m.object]
    if modifiers:
        return modifiers[0]
    parent = mesh.parent
    return parent if parent and parent.type == "ARMATURE" else None


def deforming(armature, which):
    bones = [bone for bone in armature.data.bones if which == "all" or bone.use_deform]
    if not bones:
        raise Problem(f"armature {armature.name} has no deforming bone: try --bones all")
    return bones


def frame_numbers(scene, text):
    if text is None:
        return list(range(scene.frame_start, scene.frame_end + 1, scene.frame_step))
    try:
        first, last, step = ([int(part) for part in text.split(":")] + [1])[:3]
        frames = list(range(first, last + 1, step))
    except ValueError:
        frames = []
    if not frames:
        raise Problem(f"--frames {text}: expected FIRST:LAST or FIRST:LAST:STEP")
    return frames


def faces_and_rest(scene, mesh, armature):
    """Evaluates the mesh with every bone at rest."""
    position = armature.data.pose_position
    armature.data.pose_position = "REST"
    try:
        scene.frame_set(scene.frame_current)
        with Evaluated(mesh) as (shape, world):
            rest = positions(shape, world)
            quads = [list(p.loop_indices) for p in shape.polygons if p.loop_total == 4]
            shape.calc_loop_triangles()
            others = {p.index for p in shape.polygons if p.loop_total != 4}
            tris = [list(t.loops) for t in shape.loop_triangles if t.polygon_index in others]
            vertices = np.empty(len(shape.loops), np.int32)
            shape.loops.foreach_get("vertex_index", vertices)
            uv, uv_of = coordinates(shape)
    finally:
        armature.data.pose_position = position
    if not quads and not tris:
        raise Problem(f"mesh {mesh.name} has no faces")
    found = {"rest": rest, "uv": uv}
    for name, corners in (("quads", quads), ("tris", tris)):
        if corners:
            found[name] = vertices[np.array(corners)]
            found[f"{name}_uv"] = uv_of[np.array(corners)] if len(uv) else uv
    return {name: array for name, array in found.items() if len(array)}


def coordinates(shape):
    """Texture coordinates, and which of them each corner has; none without a texture."""
    if shape.uv_layers.active is None:
        return np.empty(0), np.empty(0)
    corners = np.empty(2 * len(shape.loops), np.float32)
    shape.uv_layers.active.data.foreach_get("uv", corners)
    uv, uv_of = np.unique(corners.reshape(-1, 2), axis=0, return_inverse=True)
    return uv, uv_of.reshape(-1).astype(np.int32)


def skeleton(armature, bones):
    numbers = {bone.name: number for number, bone in enumerate(bones)}

    def parent(bone):
        above = bone.parent
        while above is not None and above.name not in numbers:
            above = above.parent
        return -1 if above is None else numbers[above.name]

    return {
        "bone_names": np.array([bone.name for bone in bones]),
        "bone_parents": np.array([parent(bone) for bone in bones], np.int32),
        "joint_world_rest": np.array([rigid(frame) for frame in rest_frames(armature, bones)]),
    }


def rest_frames(armature, bones):
    world = np.array(armature.matrix_world)
    return np.array([world @ np.array(bone.matrix_local) for bone in bones])


def poses(scene, mesh, armature, bones, frames, vertex_len):
    rest = np.linalg.inv(rest_frames(armature, bones))
    vertices = np.empty((len(frames), vertex_len, 3), np.float32)
    maps = np.empty((len(frames), len(bones), 4, 4))
    for number, frame in enumerate(frames):
        scene.frame_set(frame)
        with Evaluated(mesh) as (shape, world):
            if len(shape.vertices) != vertex_len:
                raise Problem(
                    f"frame {frame}: mesh {mesh.name} has {len(shape.vertices)} vertices, at rest "
                    f"{vertex_len}: turn off the modifier that changes them"
                )
            vertices[number] = positions(shape, world)
        posed = armature.evaluated_get(bpy.context.evaluated_depsgraph_get())
        world = np.array(posed.matrix_world)
        for joint, bone in enumerate(bones):
            maps[number, joint] = world @ np.array(posed.pose.bones[bone.name].matrix) @ rest[joint]
    return {"vertices": vertices, "bone_transforms": maps}


def rigid(matrix):
    """Takes the scale out of a frame, which an armature in other units has."""
    matrix = matrix.copy()
    matrix[:3, :3] /= np.linalg.norm(matrix[:3, :3], axis=0)
    return matrix


def positions(shape, world):
    flat = np.empty(3 * len(shape.vertices), np.float32)
    shape.vertices.foreach_get("co", flat)
    return (flat.reshape(-1, 3) @ world[:3, :3].T + world[:3, 3]).astype(np.float32)


class Evaluated:
    """The mesh of an object as it is shown, and its world matrix."""

    def __init__(self, thing):
        self.thing = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())

    def __enter__(self):
        return self.thing.to_mesh(), np.array(self.thing.matrix_world)

    def __exit__(self, *_):
        self.thing.to_mesh_clear()


if __name__ == "__main__":
    # Blender hands over what stands behind "--", with its own arguments before it.
    given = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    try:
        main(given)
    except Problem as problem:
        sys.exit(f"blender_export.py: {problem}")
