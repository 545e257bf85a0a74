"""Skins the meshes of a USD file with UsdSkel and prints the result as JSON.

usage: skin.py FILE.usda POINTS.f32 [CODE...]

Each clip is bound in turn and skinned at the time codes: POINTS.f32 gets the positions in the world, clip by clip, code
by code, mesh by mesh.
"""

import array
import json
import sys

from pxr import Gf, Usd, UsdGeom, UsdShade, UsdSkel, UsdValidation

path, points_path, *codes = sys.argv[1:]
stage = Usd.Stage.Open(path)
registry = UsdValidation.ValidationRegistry()
validators = registry.GetOrLoadAllValidators()
issues = [
    f"{issue.GetValidator().GetMetadata().name}: {issue.GetMessage()}"
    for issue in UsdValidation.ValidationContext(validators).Validate(stage)
]

root = UsdSkel.Root(stage.GetDefaultPrim())
skeleton = UsdSkel.Skeleton(root.GetPrim().GetChild("Skeleton"))
clips = [UsdSkel.Animation(prim) for prim in skeleton.GetPrim().GetChildren()]
source = UsdSkel.BindingAPI(skeleton).GetAnimationSourceRel()
bound = [target.name for target in source.GetTargets()]
meshes = [UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
place = UsdGeom.Xformable(root).ComputeLocalToWorldTransform(Usd.TimeCode.Default())

out = array.array("f")
for clip in clips:
    source.SetTargets([clip.GetPath()])
    cache = UsdSkel.Cache()
    cache.Populate(root, Usd.PrimDefaultPredicate)
    skeleton_query = cache.GetSkelQuery(skeleton)
    for code in codes:
        time = Usd.TimeCode(float(code))
        for mesh in meshes:
            query = cache.GetSkinningQuery(mesh.GetPrim())
            points = mesh.GetPointsAttr().Get()
            transforms = skeleton_query.ComputeSkinningTransforms(time)
            if not query.ComputeSkinnedPoints(transforms, points, time):
                sys.exit(f"{mesh.GetPath()} is not skinned at {code}")
            for point in points:
                out.extend(place.Transform(Gf.Vec3d(point)))
with open(points_path, "wb") as file:
    out.tofile(file)

names = lambda prims: [prim.GetDisplayName() or prim.GetName() for prim in prims]


def described(mesh):
    binding = UsdSkel.BindingAPI(mesh)
    subsets = UsdShade.MaterialBindingAPI(mesh).GetMaterialBindSubsets()
    material = lambda s: UsdShade.MaterialBindingAPI(s).GetDirectBinding().GetMaterial().GetPrim()
    texture = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
    return {
        "name": names([mesh.GetPrim()])[0],
        "influences": binding.GetJointIndicesPrimvar().GetElementSize(),
        "subsets": {
            names([material(s)])[0]: len(s.GetIndicesAttr().Get()) for s in subsets
        },
        "normals": [list(n) for n in mesh.GetNormalsAttr().Get()],
        "st": [list(x) for x in texture.Get()] if texture else [],
    }


def curves(clip):
    values = clip.GetPrim().GetAttribute("sinew:curveValues")
    return {
        "names": list(clip.GetPrim().GetAttribute("sinew:curves").Get() or []),
        "values": [list(values.Get(float(code))) for code in codes] if values else [],
    }


print(
    json.dumps(
        {
            "issues": issues,
            "validators": len(validators),
            "up": UsdGeom.GetStageUpAxis(stage),
            "metres": UsdGeom.GetStageMetersPerUnit(stage),
            "rate": stage.GetTimeCodesPerSecond(),
            "range": [stage.GetStartTimeCode(), stage.GetEndTimeCode()],
            "clips": names([clip.GetPrim() for clip in clips]),
            "samples": [clip.GetTranslationsAttr().GetTimeSamples() for clip in clips],
            "bound": bound,
            "joints": list(skeleton.GetJointNamesAttr().Get()),
            "meshes": [described(mesh) for mesh in meshes],
            "curves": [curves(clip) for clip in clips],
        }
    )
)
