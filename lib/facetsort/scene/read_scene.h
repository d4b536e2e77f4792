// Scenes in: glTF 2.0, mesh files, and folders of both.
#pragma once

#include <filesystem>
#include <span>

#include "facetsort/base/status.h"
#include "facetsort/scene/scene.h"

namespace facetsort {

// A .gltf or .glb file (any case): the nodes of its default scene that show triangles, strips or fans; an object for
// each node and primitive, a mesh for each primitive, however many nodes show it. Buffers and pictures (PNG, JPEG) may
// be in the file, in data URIs or in files beside it. Skinned and morphed meshes are as they are at rest. Of a material
// its base colour (sRGB pictures made linear, KHR_texture_transform applied), alpha mode and cutoff, sides and
// KHR_materials_transmission are kept.
//
// What engines' draw orders know beside that may stand in the extras of nodes that show a mesh, all of it or some, in
// the engines' words (see EngineSettings), and bins of Panda3D's beside its own in the extras of the scene:
//
//   {"facetsort": {"galacean": {"priority": 1},
//                  "babylon": {"renderingGroupId": 1, "alphaIndex": 2, "needDepthPrePass": true,
//                              "separateCullingPass": true, "forceDepthWrite": true, "disableDepthWrite": true},
//                  "three": {"groupOrder": 1, "renderOrder": 2, "depthTest": false, "depthWrite": false,
//                            "forceSinglePass": true},
//                  "panda3d": {"bin": "late", "drawOrder": 3, "depthTest": false, "depthWrite": false}}}
//   {"facetsort": {"panda3d": {"bins": [{"name": "late", "sort": 60, "type": "fixed"}]}}}
//
// Any other file: a mesh for read_mesh(), as one object, blended and double-sided, white with alpha 0.5 where the file
// has no colours. A folder: all files in it of either kind, by name, the names being those of files or, of glTF, as in
// it.
//
// Refuses, with one line that names the file, the fault and the place: what read_mesh() refuses, what breaks glTF's
// rules or reaches beyond its buffers, settings that no engine has, extensions that the file requires and that are not
// read here, and scenes without a facet. The scene given passes validate(). Reentrant.
Result<Scene> read_scene(const std::filesystem::path& path);

// Several files as one scene, in the order given.
Result<Scene> read_scene(std::span<const std::filesystem::path> files);

}  // namespace facetsort
