// tinygltf 2.7 checks most of what it reads. What it does not, is looked at before: chunks of a binary file that end
// after the file does, nesting as deep as the stack, and buffers that each copy the one binary chunk.
#include "facetsort/scene/gltf_file.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <exception>
#include <limits>
#include <new>
#include <string_view>
#include <utility>
#include <vector>

#include "facetsort/base/file_bytes.h"

namespace facetsort::scene_internal {
namespace {

constexpr int deepest_nesting = 128;
constexpr std::size_t most_buffer_bytes = std::size_t{1} << 33;

std::uint32_t little_endian(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= std::to_integer<std::uint32_t>(bytes[at + i]) << (8 * i);
  return value;
}

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

struct Chunks {
  std::string_view json;
  std::size_t binary_bytes = 0;
};

// Of a binary file, whose first four bytes are glTF's.
Chunks chunks_of(std::span<const std::byte> file) {
  constexpr std::uint32_t json_type = 0x4e4f534a, binary_type = 0x004e4942;
  constexpr std::size_t header = 12, chunk_header = 8;
  if (file.size() < header + chunk_header)
    throw SceneError{Fault::truncated, "the header of a binary file is cut short"};
  if (const std::uint32_t version = little_endian(file, 4); version != 2) {
    throw SceneError{Fault::unsupported_format, "glTF of version " + std::to_string(version) + ", not 2"};
  }
  const std::size_t length = little_endian(file, 8);
  if (length > file.size()) {
    throw SceneError{Fault::truncated,
                     "the file ends after " + std::to_string(file.size()) + " of " + std::to_string(length) + " bytes"};
  }
  const std::size_t json_bytes = little_endian(file, header), json_end = header + chunk_header + json_bytes;
  if (little_endian(file, header + 4) != json_type || json_end > length || json_bytes % 4 != 0) {
    throw SceneError{Fault::malformed, "the first chunk is not JSON that lies within the file"};
  }
  Chunks chunks{.json = text_of(file.subspan(header + chunk_header, json_bytes))};
  if (json_end == length) return chunks;
  if (json_end + chunk_header > length || little_endian(file, json_end + 4) != binary_type ||
      json_end + chunk_header + little_endian(file, json_end) > length) {
    throw SceneError{Fault::malformed, "the second chunk is not a binary one that lies within the file"};
  }
  chunks.binary_bytes = little_endian(file, json_end);
  return chunks;
}

// Walks over JSON without reading it: the depth of its nesting, and how many objects its list "buffers" has.
class Outline {
 public:
  explicit Outline(std::string_view json) {
    for (std::size_t i = 0; i < json.size(); ++i) {
      const char c = json[i];
      if (c == '"') {
        const std::size_t begin = ++i;
        while (i < json.size() && json[i] != '"') i += json[i] == '\\' ? 2 : 1;
        if (depth_ == 1) is_in_buffers_ = json.substr(begin, std::min(i, json.size()) - begin) == "buffers";
      } else if (c == '{' || c == '[') {
        ++depth_;
        deepest = std::max(deepest, depth_);
        buffers += c == '{' && depth_ == 3 && is_in_buffers_;
      } else if (c == '}' || c == ']') {
        --depth_;
      }
    }
  }

  int deepest = 0;
  std::size_t buffers = 0;

 private:
  int depth_ = 0;
  bool is_in_buffers_ = false;
};

void check_outline(const Chunks& chunks) {
  const Outline outline(chunks.json);
  if (outline.deepest > deepest_nesting) {
    throw SceneError{Fault::malformed, "its JSON is nested more than " + std::to_string(deepest_nesting) + " deep"};
  }
  if (chunks.binary_bytes > 0 && outline.buffers > most_buffer_bytes / chunks.binary_bytes) {
    throw SceneError{Fault::malformed, std::to_string(outline.buffers) + " buffers for one binary chunk"};
  }
}

// What tinygltf asks of the file system: files below the folder of the glTF file, by whole paths, and so many bytes in
// all.
struct Files {
  std::filesystem::path folder;
  std::size_t bytes_left = most_buffer_bytes;

  bool may_read(const std::string& path) const {
    const std::filesystem::path below = std::filesystem::path(path).lexically_normal().lexically_relative(folder);
    return !below.empty() && *below.begin() != "..";
  }
};

bool file_exists(const std::string& path, void* files) {
  std::error_code ignored;
  return static_cast<const Files*>(files)->may_read(path) && std::filesystem::is_regular_file(path, ignored);
}

std::string same_path(const std::string& path, void*) {
  return path;
}

bool read_whole_file(std::vector<unsigned char>* to, std::string* error, const std::string& path, void* files) {
  if (!static_cast<const Files*>(files)->may_read(path)) {
    *error = "not in the folder of the glTF file";
    return false;
  }
  const Result<FileBytes> file = FileBytes::open(path);
  std::size_t& left = static_cast<Files*>(files)->bytes_left;
  if (!file.ok() || file.value().bytes().size() > left) {
    *error = file.ok() ? "too large" : file.status().message;
    return false;
  }
  left -= file.value().bytes().size();
  const auto* begin = reinterpret_cast<const unsigned char*>(file.value().bytes().data());
  to->assign(begin, begin + file.value().bytes().size());
  return true;
}

// Pictures are decoded later and by need, and those in buffer views are where they are.
bool keep_picture_file(tinygltf::Image* image, int, std::string*, std::string*, int, int, const unsigned char* bytes,
                       int size, void*) {
  if (image->bufferView < 0) image->image.assign(bytes, bytes + size);
  image->as_is = true;
  return true;
}

// tinygltf's messages may run over several lines; ours have one.
std::string one_line(std::string message) {
  while (!message.empty() && (message.back() == '\n' || message.back() == '.')) message.pop_back();
  std::replace(message.begin(), message.end(), '\n', ' ');
  constexpr std::size_t longest = 300;  // a data URI may be in it
  if (message.size() > longest) message.resize(longest);
  return message;
}

// Of tinygltf, by the words of its messages.
Fault fault_of(const std::string& message) {
  return message.find("File not found") != std::string::npos || message.find("File read error") != std::string::npos
             ? Fault::cannot_read
             : Fault::malformed;
}

}  // namespace

tinygltf::Model read_gltf_model(const std::filesystem::path& path) {
  const Result<FileBytes> file = FileBytes::open(path);
  // The caller puts the name of the file in front of every message; this one has it.
  if (!file.ok()) throw SceneError{file.status().fault, file.status().message};
  const std::span<const std::byte> bytes = file.value().bytes();
  constexpr std::size_t most_bytes = std::numeric_limits<std::uint32_t>::max();
  if (bytes.size() > most_bytes) throw SceneError{Fault::unsupported_format, "glTF files end before 4 GB"};
  const bool is_binary = text_of(bytes).starts_with("glTF");
  check_outline(is_binary ? chunks_of(bytes) : Chunks{.json = text_of(bytes)});

  const std::string folder = std::filesystem::absolute(path).lexically_normal().parent_path().string();
  Files files{.folder = folder};
  tinygltf::TinyGLTF reader;
  reader.SetImageLoader(keep_picture_file, nullptr);
  reader.SetStoreOriginalJSONForExtrasAndExtensions(
      true);  // tinygltf's own values drop what is empty, and cut integers
  reader.SetFsCallbacks({file_exists, same_path, read_whole_file, nullptr, &files});
  tinygltf::Model model;
  std::string error, warning;
  bool done = false;
  try {
    done = is_binary ? reader.LoadBinaryFromMemory(&model, &error, &warning,
                                                   reinterpret_cast<const unsigned char*>(bytes.data()),
                                                   static_cast<unsigned int>(bytes.size()), folder)
                     : reader.LoadASCIIFromString(&model, &error, &warning, text_of(bytes).data(),
                                                  static_cast<unsigned int>(bytes.size()), folder);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {  // of the JSON library
    error = e.what();
  }
  if (!done) throw SceneError{fault_of(error), error.empty() ? "not a glTF file" : one_line(std::move(error))};
  return model;
}

std::span<const unsigned char> bytes_of_view(const tinygltf::Model& model, int view, const std::string& place) {
  if (view < 0 || static_cast<std::size_t>(view) >= model.bufferViews.size()) {
    throw SceneError{Fault::index_out_of_range, place + " names buffer view " + std::to_string(view) + " of " +
                                                    std::to_string(model.bufferViews.size())};
  }
  const tinygltf::BufferView& found = model.bufferViews[static_cast<std::size_t>(view)];
  if (found.buffer < 0 || static_cast<std::size_t>(found.buffer) >= model.buffers.size()) {
    throw SceneError{Fault::index_out_of_range, "buffer view " + std::to_string(view) + " names buffer " +
                                                    std::to_string(found.buffer) + " of " +
                                                    std::to_string(model.buffers.size())};
  }
  const std::vector<unsigned char>& data = model.buffers[static_cast<std::size_t>(found.buffer)].data;
  if (found.byteOffset > data.size() || found.byteLength > data.size() - found.byteOffset) {
    throw SceneError{Fault::truncated, "buffer view " + std::to_string(view) + " ends after its buffer, which has " +
                                           std::to_string(data.size()) + " bytes"};
  }
  return std::span(data).subspan(found.byteOffset, found.byteLength);
}

}  // namespace facetsort::scene_internal
