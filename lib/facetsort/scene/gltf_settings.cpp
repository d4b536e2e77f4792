#include "facetsort/scene/gltf_settings.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "facetsort/scene/gltf_file.h"

namespace facetsort::scene_internal {
namespace {

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

bool read(const Value& value, double& to) {
  if (!value.IsNumber() || !std::isfinite(value.GetNumberAsDouble())) return false;
  to = value.GetNumberAsDouble();
  return true;
}

bool read(const Value& value, bool& to) {
  if (!value.IsBool()) return false;
  to = value.Get<bool>();
  return true;
}

bool read(const Value& value, std::string& to) {
  if (!value.IsString()) return false;
  to = value.Get<std::string>();
  return true;
}

bool read(const Value& value, std::optional<std::string>& to) {
  return read(value, to.emplace());
}

template <typename Integer>
bool read_whole(const Value& value, Integer& to) {
  double number = 0;
  if (!read(value, number) || std::floor(number) != number ||
      number < static_cast<double>(std::numeric_limits<Integer>::min()) ||
      number > static_cast<double>(std::numeric_limits<Integer>::max())) {
    return false;
  }
  to = static_cast<Integer>(number);
  return true;
}

bool read(const Value& value, int& to) {
  return read_whole(value, to);
}

bool read(const Value& value, std::uint32_t& to) {
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

// The own part of extras, an object; null where there is none.
const Value* own_part(const Value& extras, const std::string& place) {
  if (!extras.IsObject() || !extras.Has(own_key)) return nullptr;
  const Value& own = extras.Get(own_key);
  if (!own.IsObject()) refuse(place, "extras." + std::string(own_key) + " is no object");
  return &own;
}

// Refuses members of `object` that are not among `known`.
void refuse_others(const Value& object, const std::vector<std::string>& known, const std::string& place) {
  for (const std::string& key : object.Keys()) {
    if (std::find(known.begin(), known.end(), key) == known.end()) refuse(place, "no setting is '" + key + "'");
  }
}

Value in_own_part(Value::Object content) {
  Value::Object extras;
  extras[own_key] = Value(std::move(content));
  return Value(std::move(extras));
}

Panda3DBin read_bin(const Value& from, const std::string& place) {
  if (!from.IsObject()) refuse(place, "a bin that is no object");
  refuse_others(from, {"name", "sort", "type"}, place);
  Panda3DBin bin;
  std::string type;
  if (!from.Has("name") || !read(from.Get("name"), bin.name)) refuse(place, "a bin without a name");
  if (!from.Has("sort") || !read(from.Get("sort"), bin.sort)) refuse(place, "a bin whose sort is no whole number");
  if (!from.Has("type") || !read(from.Get("type"), type)) refuse(place, "a bin without a type");
  const auto* found =
      std::find_if(std::begin(bin_types), std::end(bin_types), [&](const auto& entry) { return entry.second == type; });
  if (found == std::end(bin_types)) refuse(place, "no type of bins is '" + type + "'");
  bin.type = found->first;
  return bin;
}

}  // namespace

EngineSettings read_settings(const Value& extras, const std::string& place) {
  EngineSettings settings;
  const Value* own = own_part(extras, place);
  if (own == nullptr) return settings;
  std::map<std::string, std::vector<std::string>> known;
  const auto read_one = [&](const std::string& engine, const std::string& key, auto& setting) {
    known[engine].push_back(key);
    if (!own->Has(engine)) return;
    const Value& of_engine = own->Get(engine);
    if (!of_engine.IsObject()) refuse(place, "extras: " + engine + " is no object");
    if (of_engine.Has(key) && !read(of_engine.Get(key), setting)) {
      refuse(place, "extras: " + engine + "." + key + " is of the wrong type or out of range");
    }
  };
  for_each_setting(read_one, settings);
  for (const std::string& engine : own->Keys()) {
    if (!known.contains(engine)) refuse(place, "extras: no engine is '" + engine + "'");
    refuse_others(own->Get(engine), known[engine], place + " extras, " + engine);
  }
  return settings;
}

std::vector<Panda3DBin> read_bins(const Value& extras, const std::string& place) {
  std::vector<Panda3DBin> bins;
  const Value* own = own_part(extras, place);
  if (own == nullptr) return bins;
  refuse_others(*own, {"panda3d"}, place + " extras");
  if (!own->Has("panda3d")) return bins;
  const Value& panda3d = own->Get("panda3d");
  if (!panda3d.IsObject()) refuse(place, "extras: panda3d is no object");
  refuse_others(panda3d, {"bins"}, place + " extras, panda3d");
  if (!panda3d.Has("bins")) return bins;
  const Value& list = panda3d.Get("bins");
  if (!list.IsArray()) refuse(place, "extras: panda3d.bins is no list");
  for (std::size_t i = 0; i < list.ArrayLen(); ++i) {
    bins.push_back(read_bin(list.Get(static_cast<int>(i)), place + " extras, bin " + std::to_string(i)));
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
