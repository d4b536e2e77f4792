// Internal to scene: a glTF file as tinygltf has it, read so that no file makes tinygltf read or fill memory that it
// should not.
#pragma once

#include <tiny_gltf.h>

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "facetsort/base/status.h"

namespace facetsort::scene_internal {

// Thrown between the parts of the reader, and turned into a Status by read_scene(). The message has the place, and no
// file name yet.
struct SceneError {
  Fault fault;
  std::string message;
};

// Buffers are loaded; pictures are left as the bytes of their files, or in their buffer views. Throws SceneError.
tinygltf::Model read_gltf_model(const std::filesystem::path& path);

// The bytes of a buffer view; `place` names who asks. Throws SceneError where there is none or it lies outside of its
// buffer.
std::span<const unsigned char> bytes_of_view(const tinygltf::Model& model, int view, const std::string& place);

}  // namespace facetsort::scene_internal
