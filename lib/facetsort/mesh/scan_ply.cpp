// PLY, the Stanford polygon format: ASCII and both binary encodings, any elements and properties.
#include <array>
#include <bit>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "facetsort/mesh/plain_ply.h"
#include "facetsort/mesh/text.h"

namespace facetsort {
namespace {

enum class Encoding { ascii, little_endian, big_endian };

struct Type {
  std::string_view name, other_name;
  std::size_t size;
  bool is_float, is_signed;
};

constexpr std::array<Type, 8> types{{{"char", "int8", 1, false, true},
                                     {"uchar", "uint8", 1, false, false},
                                     {"short", "int16", 2, false, true},
                                     {"ushort", "uint16", 2, false, false},
                                     {"int", "int32", 4, false, true},
                                     {"uint", "uint32", 4, false, false},
                                     {"float", "float32", 4, true, true},
                                     {"double", "float64", 8, true, true}}};

// What a property means to us.
enum class Role { ignored, coordinate, red, green, blue, alpha, corners, source };

struct Property {
  std::string_view name;
  const Type* type;
  const Type* count_type;  // of a list; null for a scalar
  Role role = Role::ignored;
};

struct Element {
  std::string_view name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
  std::size_t size = 0, lines = 0;  // up to the body
};

// --- header ---------------------------------------------------------------------------------------------------------

class HeaderReader {
 public:
  explicit HeaderReader(std::string_view file) : file_(file) {}

  Header read() {
    if (file_.substr(0, 3) != "ply" && file_.substr(0, 3) != "PLY") {
      throw ReadError{Fault::unsupported_format, "no PLY file: it does not start with ply"};
    }
    next_line();
    if (words_.size() != 1 || words_[0].size() != 3) throw malformed("ply expected");
    next_line();
    if (words_.size() != 3 || words_[0] != "format") throw malformed("format expected");
    header_.encoding = encoding(words_[1]);
    for (next_line(); words_.empty() || words_[0] != "end_header"; next_line()) {
      if (words_.empty() || words_[0] == "comment" || words_[0] == "obj_info") continue;
      if (words_[0] == "element") {
        add_element();
      } else if (words_[0] == "property") {
        add_property();
      } else {
        throw malformed("element, property or end_header expected");
      }
    }
    header_.size = offset_;
    header_.lines = line_;
    return std::move(header_);
  }

 private:
  ReadError malformed(const std::string& what) const {
    return {Fault::malformed, "header line " + std::to_string(line_) + ": " + what};
  }

  // The first line's end is every line's: a binary body may start with a byte that looks like a part of one.
  void next_line() {
    if (line_ == 0) {
      const std::size_t end = file_.find_first_of("\r\n");
      newline_ =
          file_.substr(end == file_.npos ? 0 : end).starts_with('\r') && file_.substr(end, 2) != "\r\n" ? '\r' : '\n';
    }
    const std::size_t end = file_.find(newline_, offset_);
    if (end == file_.npos) throw ReadError{Fault::truncated, "truncated: no end_header"};
    words_.clear();
    for (std::size_t begin = offset_; begin < end;) {
      std::size_t word_end = begin;
      while (word_end < end && !text::is_space(file_[word_end])) ++word_end;
      if (word_end > begin) words_.push_back(file_.substr(begin, word_end - begin));
      begin = word_end + 1;
    }
    offset_ = end + 1;
    ++line_;
  }

  Encoding encoding(std::string_view name) const {
    if (name == "ascii") return Encoding::ascii;
    if (name == "binary_little_endian") return Encoding::little_endian;
    if (name == "binary_big_endian") return Encoding::big_endian;
    throw ReadError{Fault::unsupported_format,
                    "header line " + std::to_string(line_) + ": unknown format " + std::string(name.substr(0, 40))};
  }

  void add_element() {
    Element element;
    if (words_.size() != 3) throw malformed("element NAME COUNT expected");
    element.name = words_[1];
    const std::optional<std::size_t> count = text::parse_integer<std::size_t>(words_[2]);
    if (!count) throw malformed("a count expected");
    element.count = *count;
    for (const Element& other : header_.elements) {
      if (other.name == element.name) throw malformed("a second element of that name");
    }
    header_.elements.push_back(std::move(element));
  }

  const Type* type(std::string_view name) const {
    for (const Type& candidate : types) {
      if (name == candidate.name || name == candidate.other_name) return &candidate;
    }
    throw malformed("unknown type " + std::string(name.substr(0, 40)));
  }

  void add_property() {
    if (header_.elements.empty()) throw malformed("a property before the first element");
    Property property;
    if (words_.size() == 5 && words_[1] == "list") {
      property = {words_[4], type(words_[3]), type(words_[2])};
      if (property.count_type->is_float) throw malformed("a list count that is no integer");
    } else if (words_.size() == 3) {
      property = {words_[2], type(words_[1]), nullptr};
    } else {
      throw malformed("property TYPE NAME or property list TYPE TYPE NAME expected");
    }
    Element& element = header_.elements.back();
    property.role = role(element, property);
    if (property.role != Role::ignored) {
      for (const Property& other : element.properties) {
        if (other.name == property.name || (other.role == Role::corners && property.role == Role::corners)) {
          throw malformed("a second property of that name");
        }
      }
    }
    element.properties.push_back(property);
  }

  Role role(const Element& element, const Property& property) const {
    const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
    if (!is_vertex && !is_face) return Role::ignored;
    if (property.count_type) {
      if (!is_face || (property.name != "vertex_indices" && property.name != "vertex_index")) return Role::ignored;
      if (property.type->is_float) throw malformed("corners that are no integers");
      return Role::corners;
    }
    if (is_vertex && (property.name == "x" || property.name == "y" || property.name == "z")) {
      // OpenMesh reads integers in text as floats, but not in binary.
      if (!property.type->is_float && header_.encoding != Encoding::ascii) {
        throw ReadError{Fault::unsupported_format, "header line " + std::to_string(line_) + ": integer coordinates"};
      }
      return Role::coordinate;
    }
    if (is_face && property.name == "source" && !property.type->is_float) return Role::source;
    std::string_view name = property.name;
    if (name.starts_with("diffuse_")) name.remove_prefix(8);
    if (name == "red") return Role::red;
    if (name == "green") return Role::green;
    if (name == "blue") return Role::blue;
    return name == "alpha" ? Role::alpha : Role::ignored;
  }

  std::string_view file_;
  char newline_ = '\n';
  std::size_t offset_ = 0, line_ = 0;
  std::vector<std::string_view> words_;
  Header header_;
};

// --- body -----------------------------------------------------------------------------------------------------------

// Walks the body value by value. A value is the text of a word, or the bytes of a number.
class Body {
 public:
  Body(std::string_view file, const Header& header)
      : encoding_(header.encoding),
        header_lines_(header.lines),
        bytes_(file.substr(header.size)),
        lines_(encoding_ == Encoding::ascii ? bytes_ : std::string_view{}) {}

  // Before each instance of an element that has properties; false where the file has ended.
  bool next_instance() {
    if (encoding_ != Encoding::ascii) return offset_ < bytes_.size();
    word_ = 0;
    return lines_.next();
  }

  // Nothing where the file has ended, or the line.
  std::optional<std::string_view> take(const Type& type) { return take(type, 1); }

  // `count` values of a list together.
  std::optional<std::string_view> take(const Type& type, std::size_t count) {
    if (encoding_ == Encoding::ascii) {
      if (lines_.words().size() - word_ < count) return std::nullopt;
      if (count == 0) return std::string_view{};
      const std::string_view first = lines_.words()[word_], last = lines_.words()[word_ + count - 1];
      word_ += count;
      return std::string_view(first.data(), static_cast<std::size_t>(last.data() + last.size() - first.data()));
    }
    if ((bytes_.size() - offset_) / type.size < count) return std::nullopt;
    const std::string_view taken = bytes_.substr(offset_, count * type.size);
    offset_ += taken.size();
    return taken;
  }

  // Nothing where a word is no such number.
  std::optional<double> value(const Type& type, std::string_view taken) const {
    if (encoding_ == Encoding::ascii) {
      if (type.is_float) return text::parse_float(taken);
      const std::optional<std::int64_t> integer = text::parse_integer<std::int64_t>(taken);
      if (!integer) return std::nullopt;
      return static_cast<double>(*integer);
    }
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < taken.size(); ++i) {
      const std::size_t place = encoding_ == Encoding::big_endian ? i : taken.size() - 1 - i;
      bits = bits << 8 | static_cast<unsigned char>(taken[place]);
    }
    if (type.is_float) {
      return type.size == 4 ? std::bit_cast<float>(static_cast<std::uint32_t>(bits)) : std::bit_cast<double>(bits);
    }
    const std::uint64_t sign = std::uint64_t{type.is_signed} << (8 * type.size - 1);
    return static_cast<double>(static_cast<std::int64_t>(bits ^ sign) - static_cast<std::int64_t>(sign));
  }

  // The fault of an instance of which a value could not be taken.
  bool is_cut() const { return encoding_ != Encoding::ascii || lines_.is_cut(); }
  // The place, where the file has lines.
  std::string at_line() const {
    return encoding_ == Encoding::ascii ? "line " + std::to_string(header_lines_ + lines_.number()) + ": " : "";
  }
  bool is_line_done() const { return encoding_ != Encoding::ascii || word_ == lines_.words().size(); }
  // Of a binary body, and of a text in words that are left over.
  bool is_done() {
    return encoding_ == Encoding::ascii ? !lines_.next() : bytes_.find_first_not_of(" \t\r\n", offset_) == bytes_.npos;
  }

 private:
  Encoding encoding_;
  std::size_t header_lines_;
  std::string_view bytes_;
  std::size_t offset_ = 0, word_ = 0;
  text::Lines lines_;
};

// Values of one instance that we look at ourselves; colours still have the file's scale.
struct Instance {
  std::size_t corners = 0;
  glm::vec4 colour{1};
  std::uint32_t source = 0;
};

bool has_role(const Element& element, Role role) {
  for (const Property& property : element.properties) {
    if (property.role == role) return true;
  }
  return false;
}

bool has_colour(const Element& element) {
  return has_role(element, Role::red) && has_role(element, Role::green) && has_role(element, Role::blue);
}

class Scanner {
 public:
  explicit Scanner(std::string_view file) : header_(HeaderReader(file).read()), body_(file, header_) {}

  PlainPly scan() {
    for (const Element& element : header_.elements) {
      if (element.name == "vertex") vertex_element_ = &element;
      if (element.name == "face") face_element_ = &element;
    }
    check_elements();
    for (const Element& element : header_.elements) scan_element(element);
    if (!body_.is_done()) {
      throw ReadError{Fault::malformed, body_.at_line() + "the file goes on after its last element"};
    }
    finish();
    return std::move(plain_);
  }

 private:
  void check_elements() const {
    if (!vertex_element_) throw ReadError{Fault::malformed, "no vertex element"};
    if (!face_element_ || face_element_->count == 0) throw ReadError{Fault::empty_mesh, "no facet"};
    std::size_t coordinates = 0;
    for (const Property& property : vertex_element_->properties) coordinates += property.role == Role::coordinate;
    if (coordinates != 3) throw ReadError{Fault::malformed, "the vertices have no x, y and z"};
    if (!has_role(*face_element_, Role::corners)) {
      throw ReadError{Fault::unsupported_format, "the faces have no list vertex_indices"};
    }
  }

  void scan_element(const Element& element) {
    // Nothing in the file: a count of billions would only take time.
    if (element.properties.empty()) return;
    const bool is_vertex = &element == vertex_element_, is_face = &element == face_element_;
    const bool coloured = has_colour(element), sourced = has_role(element, Role::source);
    for (std::size_t i = 0; i < element.count; ++i) {
      if (!body_.next_instance()) throw truncated(element, i);
      Instance instance;
      for (const Property& property : element.properties) scan_property(element, i, property, instance);
      if (!body_.is_line_done()) {
        throw ReadError{Fault::malformed, body_.at_line() + name(element, i) + " has more values than its header says"};
      }
      if (is_vertex && coloured) plain_.vertex_colours.push_back(instance.colour);
      if (is_face && coloured) {
        plain_.facet_colours.insert(plain_.facet_colours.end(), instance.corners - 2, instance.colour);
      }
      if (sourced) plain_.source.insert(plain_.source.end(), instance.corners - 2, instance.source);
    }
  }

  void scan_property(const Element& element, std::size_t i, const Property& property, Instance& instance) {
    if (property.count_type) return scan_list(element, i, property, instance);
    const std::string_view taken = take(element, i, *property.type, 1);
    switch (property.role) {
      case Role::coordinate:
        vertex_bytes_ += taken;
        if (is_text()) vertex_bytes_ += ' ';
        return;
      case Role::red:
      case Role::green:
      case Role::blue:
      case Role::alpha: {
        const int channel = static_cast<int>(property.role) - static_cast<int>(Role::red);
        instance.colour[channel] = colour_channel(element, i, *property.type, taken);
        return;
      }
      case Role::source: {
        const double source = value(element, i, *property.type, taken);
        if (source < 0 || source > std::numeric_limits<std::uint32_t>::max()) {
          throw ReadError{Fault::malformed, body_.at_line() + name(element, i) + " has a source that is no facet id"};
        }
        instance.source = static_cast<std::uint32_t>(source);
        return;
      }
      case Role::corners:
      case Role::ignored:
        return;
    }
  }

  void scan_list(const Element& element, std::size_t i, const Property& property, Instance& instance) {
    const std::string_view count_taken = take(element, i, *property.count_type, 1);
    const double count = value(element, i, *property.count_type, count_taken);
    if (count < 0) {
      throw ReadError{Fault::malformed, body_.at_line() + name(element, i) + " has a list of negative length"};
    }
    const std::string_view taken = take(element, i, *property.type, static_cast<std::size_t>(count));
    if (property.role != Role::corners) return;
    if (count < 3) {
      throw ReadError{Fault::malformed, body_.at_line() + name(element, i) + " has " +
                                            std::to_string(static_cast<int>(count)) + " corners, fewer than 3"};
    }
    instance.corners = static_cast<std::size_t>(count);
    face_bytes_ += count_taken;
    if (is_text()) face_bytes_ += ' ';
    face_bytes_ += taken;
    if (is_text()) face_bytes_ += '\n';
  }

  std::string_view take(const Element& element, std::size_t i, const Type& type, std::size_t count) {
    const std::optional<std::string_view> taken = body_.take(type, count);
    if (taken) return *taken;
    if (body_.is_cut()) throw truncated(element, i);
    throw ReadError{Fault::malformed, body_.at_line() + name(element, i) + " has fewer values than its header says"};
  }

  // Integers stand for 0 to 1 by their type's range; of the other integer types than uchar and ushort, by a byte's.
  float colour_channel(const Element& element, std::size_t i, const Type& type, std::string_view taken) const {
    const float scale = type.is_float ? 1.0f : type.name == "ushort" ? 65535.0f : 255.0f;
    const float channel = static_cast<float>(value(element, i, type, taken)) / scale;
    if (channel >= 0 && channel <= 1) return channel;
    throw ReadError{Fault::malformed, body_.at_line() + name(element, i) + " has a colour outside its range"};
  }

  double value(const Element& element, std::size_t i, const Type& type, std::string_view taken) const {
    const std::optional<double> number = body_.value(type, taken);
    if (!number) {
      throw ReadError{Fault::malformed,
                      body_.at_line() + name(element, i) + " has a value that is no " + std::string(type.name)};
    }
    return *number;
  }

  static std::string name(const Element& element, std::size_t i) {
    const std::string kind = element.name == "face" ? "facet" : std::string(element.name.substr(0, 40));
    return kind + " " + std::to_string(i);
  }

  static ReadError truncated(const Element& element, std::size_t read) {
    const std::string kind = element.name == "face"     ? "facets"
                             : element.name == "vertex" ? "vertices"
                                                        : "elements of kind " + std::string(element.name.substr(0, 40));
    return {Fault::truncated,
            "truncated: " + std::to_string(read) + " of " + std::to_string(element.count) + " " + kind + " read"};
  }

  bool is_text() const { return header_.encoding == Encoding::ascii; }

  // The count types that OpenMesh knows are uchar, uint16 and int; a text has no sizes.
  void finish() {
    std::string vertex_properties;
    std::string_view corner_type = "int", count_type = "int";
    for (const Property& property : vertex_element_->properties) {
      if (property.role != Role::coordinate) continue;
      vertex_properties += is_text() ? "property float " : "property " + std::string(property.type->name) + " ";
      vertex_properties += property.name;
      vertex_properties += '\n';
    }
    for (const Property& property : face_element_->properties) {
      if (property.role != Role::corners || is_text()) continue;
      corner_type = property.type->name;
      count_type = property.count_type->size == 1 ? "uchar" : property.count_type->size == 2 ? "uint16" : "int";
    }
    const std::string_view encoding = is_text()                                  ? "ascii"
                                      : header_.encoding == Encoding::big_endian ? "binary_big_endian"
                                                                                 : "binary_little_endian";
    plain_.vertices = vertex_element_->count;
    plain_.faces = face_element_->count;
    plain_.bytes = plain_header(encoding, vertex_properties, std::string(count_type) + " " + std::string(corner_type),
                                plain_.vertices, plain_.faces);
    plain_.bytes.reserve(plain_.bytes.size() + vertex_bytes_.size() + face_bytes_.size());
    plain_.bytes += std::exchange(vertex_bytes_, {});
    plain_.bytes += std::exchange(face_bytes_, {});
  }

  Header header_;
  Body body_;
  const Element* vertex_element_ = nullptr;
  const Element* face_element_ = nullptr;
  std::string vertex_bytes_, face_bytes_;
  PlainPly plain_;
};

}  // namespace

PlainPly scan_ply(std::string_view file) {
  return Scanner(file).scan();
}

}  // namespace facetsort
