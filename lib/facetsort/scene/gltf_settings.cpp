#include "facetsort/scene/gltf_settings.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "facetsort/scene/gltf_file.h"

namespace facetsort::scene_internal {
namespace {

using Json = nlohmann::json;
using tinygltf::Value;

// Beside what others keep in extras.
constexpr const char* own_key = "facetsort";

constexpr std::pair<Panda3DBinType, const char*> bin_types[] = {{Panda3DBinType::fixed, "fixed"},
                                                                {Panda3DBinType::state_sorted, "state_sorted"},
                                                                {Panda3DBinType::back_to_front, "back_to_front"},
                                                                {Panda3DBinType::front_to_back, "front_to_back"},
                                                                {Panda3DBinType::unsorted, "unsorted"}};

// Hands visit(name of the engine, name of the setting, the setting in each of `settings`) each of them.
template <typename Visit, typename... Settings>
void for_each_setting(const Visit& visit, Settings&... settings) {
  visit("galacean", "priority", settings.galacean.priority...);
  visit("babylon", "renderingGroupId", settings.babylon.rendering_group_id...);
  visit("babylon", "alphaIndex", settings.babylon.alpha_index...);
  visit("babylon", "needDepthPrePass", settings.babylon.need_depth_pre_pass...);
  visit("babylon", "separateCullingPass", settings.babylon.separate_culling_pass...);
  visit("babylon", "forceDepthWrite", settings.babylon.force_depth_write...);
  visit("babylon", "disableDepthWrite", settings.babylon.disable_depth_write...);
  visit("three", "groupOrder", settings.three.group_order...);
  visit("three", "renderOrder", settings.three.render_order...);
  visit("three", "depthTest", settings.three.depth_test...);
  visit("three", "depthWrite", settings.three.depth_write...);
  visit("three", "forceSinglePass", settings.three.force_single_pass...);
  visit("panda3d", "bin", settings.panda3d.bin...);
  visit("panda3d", "drawOrder", settings.panda3d.draw_order...);
  visit("panda3d", "depthTest", settings.panda3d.depth_test...);
  visit("panda3d", "depthWrite", settings.panda3d.depth_write...);
}

[[noreturn]] void refuse(const std::string& place, const std::string& what) {
  throw SceneError{Fault::malformed, place + ": " + what};
}

bool read(const Json& value, double& to) {
  if (!value.is_number() || !std::isfinite(value.get<double>())) return false;
  to = value.get<double>();
  return true;
}

bool read(const Json& value, bool& to) {
  if (!value.is_boolean()) return false;
  to = value.get<bool>();
  return true;
}

bool read(const Json& value, std::string& to) {
  if (!value.is_string()) return false;
  to = value.get<std::string>();
  return true;
}

bool read(const Json& value, std::optional<std::string>& to) {
  return read(value, to.emplace());
}

template <typename Integer>
bool read_whole(const Json& value, Integer& to) {
  double number = 0;
  if (!read(value, number) || std::floor(number) != number ||
      number < static_cast<double>(std::numeric_limits<Integer>::min()) ||
      number > static_cast<double>(std::numeric_limits<Integer>::max())) {
    return false;
  }
  to = static_cast<Integer>(number);
  return true;
}

bool read(const Json& value, int& to) {
  return read_whole(value, to);
}

bool read(const Json& value, std::uint32_t& to) {
  return read_whole(value, to);
}

template <typename T>
std::optional<Value> written(const T& setting, const T& standard) {
  if (setting == standard) return std::nullopt;
  return Value(setting);
}

std::optional<Value> written(std::uint32_t setting, std::uint32_t standard) {
  return written(static_cast<int>(setting), static_cast<int>(standard));
}

std::optional<Value> written(const std::optional<std::string>& setting, const std::optional<std::string>& standard) {
  if (setting == standard) return std::nullopt;
  return Value(*setting);
}

// The own part of extras, an object; none where there is none.
std::optional<Json> own_part(const std::string& extras, const std::string& place) {
  Json json = Json::parse(extras, nullptr, false);
  if (!json.is_object() || !json.contains(own_key)) return std::nullopt;
  if (!json[own_key].is_object()) refuse(place, "extras." + std::string(own_key) + " is no object");
  return std::move(json[own_key]);
}

// Refuses members of `object` that are not among `known`.
void refuse_others(const Json& object, const std::vector<std::string>& known, const std::string& place) {
  for (const auto& member : object.items()) {
    if (std::find(known.begin(), known.end(), member.key()) == known.end()) {
      refuse(place, "no setting is '" + member.key() + "'");
    }
  }
}

Value in_own_part(Value::Object content) {
  Value::Object extras;
  extras[own_key] = Value(std::move(content));
  return Value(std::move(extras));
}

Panda3DBin read_bin(const Json& from, const std::string& place) {
  if (!from.is_object()) refuse(place, "a bin that is no object");
  refuse_others(from, {"name", "sort", "type"}, place);
  Panda3DBin bin;
  std::string type;
  if (!from.contains("name") || !read(from["name"], bin.name)) refuse(place, "a bin without a name");
  if (!from.contains("sort") || !read(from["sort"], bin.sort)) refuse(place, "a bin whose sort is no whole number");
  if (!from.contains("type") || !read(from["type"], type)) refuse(place, "a bin without a type");
  const auto* found =
      std::find_if(std::begin(bin_types), std::end(bin_types), [&](const auto& entry) { return entry.second == type; });
  if (found == std::end(bin_types)) refuse(place, "no type of bins is '" + type + "'");
  bin.type = found->first;
  return bin;
}

}  // namespace

EngineSettings read_settings(const std::string& extras, const std::string& place) {
  EngineSettings settings;
  const std::optional<Json> own = own_part(extras, place);
  if (!own) return settings;
  std::map<std::string, std::vector<std::string>> known;
  const auto read_one = [&](const std::string& engine, const std::string& key, auto& setting) {
    known[engine].push_back(key);
    if (!own->contains(engine)) return;
    const Json& of_engine = (*own)[engine];
    if (!of_engine.is_object()) refuse(place, "extras: " + engine + " is no object");
    if (of_engine.contains(key) && !read(of_engine[key], setting)) {
      refuse(place, "extras: " + engine + "." + key + " is of the wrong type or out of range");
    }
  };
  for_each_setting(read_one, settings);
  for (const auto& engine : own->items()) {
    if (!known.contains(engine.key())) refuse(place, "extras: no engine is '" + engine.key() + "'");
    refuse_others(engine.value(), known[engine.key()], place + " extras, " + engine.key());
  }
  return settings;
}

std::vector<Panda3DBin> read_bins(const std::string& extras, const std::string& place) {
  std::vector<Panda3DBin> bins;
  const std::optional<Json> own = own_part(extras, place);
  if (!own) return bins;
  refuse_others(*own, {"panda3d"}, place + " extras");
  if (!own->contains("panda3d")) return bins;
  const Json& panda3d = (*own)["panda3d"];
  if (!panda3d.is_object()) refuse(place, "extras: panda3d is no object");
  refuse_others(panda3d, {"bins"}, place + " extras, panda3d");
  if (!panda3d.contains("bins")) return bins;
  if (!panda3d["bins"].is_array()) refuse(place, "extras: panda3d.bins is no list");
  for (const Json& bin : panda3d["bins"]) {
    bins.push_back(read_bin(bin, place + " extras, bin " + std::to_string(bins.size())));
  }
  return bins;
}

Value extras_of(const EngineSettings& settings) {
  const EngineSettings standard;
  if (settings == standard) return {};
  std::map<std::string, Value::Object> by_engine;
  const auto write = [&](const char* engine, const char* key, const auto& setting, const auto& by_default) {
    if (const std::optional<Value> value = written(setting, by_default)) by_engine[engine][key] = *value;
  };
  for_each_setting(write, settings, standard);
  Value::Object engines;
  for (auto& [engine, of_engine] : by_engine) engines[engine] = Value(std::move(of_engine));
  return in_own_part(std::move(engines));
}

Value extras_of(const std::vector<Panda3DBin>& bins) {
  if (bins.empty()) return {};
  Value::Array list;
  for (const Panda3DBin& bin : bins) {
    Value::Object entry;
    entry["name"] = Value(bin.name);
    entry["sort"] = Value(bin.sort);
    entry["type"] = Value(std::string(std::find_if(std::begin(bin_types), std::end(bin_types), [&](const auto& known) {
                                        return known.first == bin.type;
                                      })->second));
    list.push_back(Value(std::move(entry)));
  }
  Value::Object panda3d, own;
  panda3d["bins"] = Value(std::move(list));
  own["panda3d"] = Value(std::move(panda3d));
  return in_own_part(std::move(own));
}

}  // namespace facetsort::scene_internal
