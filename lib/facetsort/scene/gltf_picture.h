// Internal to scene: the pictures of glTF, PNG and JPEG, decoded and encoded by the library that tinygltf brings (stb).
#pragma once

#include <tiny_gltf.h>

#include <string>
#include <vector>

#include "facetsort/mesh/material.h"

namespace facetsort::scene_internal {

// Texels of picture `image`, from sRGB to linear. Wrap modes are left alone. Throws SceneError; `place` names who asks.
void decode_picture(const tinygltf::Model& model, int image, const std::string& place, Texture& texture);

// The bytes of a PNG with 8 bits a channel, from linear to sRGB; values outside of 0 to 1 are clamped. Empty where it
// can't be made.
std::vector<unsigned char> encode_picture(const Texture& texture);

}  // namespace facetsort::scene_internal
