// glTF files for tests, part by part: numbers go into one buffer, the rest is JSON as a person would write it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace facetsort {

inline std::string base64(std::string_view bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k > bytes.size() ? '=' : digits[group >> (18 - 6 * k) & 63];
    }
  }
  return text;
}

class GltfText {
 public:
  // Lists of JSON objects, and further members of the whole with their commas.
  std::string nodes, meshes, materials, textures, images, samplers, cameras;
  std::string scene_nodes = "0";
  std::string more;

  // The number of a buffer view of these values.
  template <typename T>
  int add_view(const std::vector<T>& values, int stride = 0) {
    buffer.resize((buffer.size() + 3) / 4 * 4);
    const std::size_t offset = buffer.size(), bytes = values.size() * sizeof(T);
    buffer.append(reinterpret_cast<const char*>(values.data()), bytes);
    add(views_, R"({"buffer":0,"byteOffset":)" + std::to_string(offset) + R"(,"byteLength":)" + std::to_string(bytes) +
                    (stride > 0 ? R"(,"byteStride":)" + std::to_string(stride) : "") + "}");
    return view_count_++;
  }

  // The number of an accessor; `type` is glTF's word, `component` its number.
  int add_accessor(int view, std::size_t count, const std::string& type, int component, const std::string& rest = "") {
    add(accessors_, R"({"bufferView":)" + std::to_string(view) + R"(,"count":)" + std::to_string(count) +
                        R"(,"type":")" + type + R"(","componentType":)" + std::to_string(component) + rest + "}");
    return accessor_count_++;
  }
  int add_raw_accessor(const std::string& json) {
    add(accessors_, json);
    return accessor_count_++;
  }
  // Three floats each.
  int add_positions(const std::vector<float>& values) {
    return add_accessor(add_view(values), values.size() / 3, "VEC3", 5126);
  }

  std::string json(const std::string& buffer_uri) const {
    std::string text = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[)" + scene_nodes + "]}]";
    const auto list = [&](const char* name, const std::string& content) {
      if (!content.empty()) text += ",\"" + std::string(name) + "\":[" + content + "]";
    };
    list("nodes", nodes);
    list("meshes", meshes);
    list("materials", materials);
    list("textures", textures);
    list("images", images);
    list("samplers", samplers);
    list("cameras", cameras);
    list("accessors", accessors_);
    list("bufferViews", views_);
    if (!buffer.empty()) {
      list("buffers", R"({"byteLength":)" + std::to_string(buffer.size()) +
                          (buffer_uri.empty() ? "" : R"(,"uri":")" + buffer_uri + "\"") + "}");
    }
    return text + more + "}";
  }

  std::string gltf() const { return json("data:application/octet-stream;base64," + base64(buffer)); }

  std::string glb() const {
    std::string text = json(""), binary = buffer;
    text.resize((text.size() + 3) / 4 * 4, ' ');
    binary.resize((binary.size() + 3) / 4 * 4, '\0');
    std::string file = "glTF" + word(2) + word(28 + text.size() + binary.size());
    file += word(text.size()) + "JSON" + text;
    return file + word(binary.size()) + std::string("BIN\0", 4) + binary;
  }

  static std::string word(std::size_t value) {
    std::string bytes;
    for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> (8 * i) & 255);
    return bytes;
  }

  std::string buffer;

 private:
  static void add(std::string& list, const std::string& item) { list += (list.empty() ? "" : ",") + item; }

  std::string accessors_, views_;
  int accessor_count_ = 0, view_count_ = 0;
};

// One triangle with corners at the origin and at 1 on x and y; accessor 0, mesh 0.
inline GltfText one_triangle() {
  GltfText text;
  text.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
  text.meshes = R"({"name":"triangle","primitives":[{"attributes":{"POSITION":0}}]})";
  text.nodes = R"({"name":"node","mesh":0})";
  return text;
}

}  // namespace facetsort
