// What an engine's user sets of the draw order, object by object, beside materials: in each engine's own words, with
// its defaults.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

namespace facetsort {

struct EngineSettings {
  struct Galacean {
    double priority = 0;  // of the renderer; smaller is drawn first
    bool operator==(const Galacean&) const = default;
  } galacean{};
  struct Babylon {
    std::uint32_t rendering_group_id = 0;  // up to most_rendering_groups - 1
    double alpha_index = std::numeric_limits<double>::max();
    bool need_depth_pre_pass = false, separate_culling_pass = false;
    bool force_depth_write = false, disable_depth_write = false;
    bool operator==(const Babylon&) const = default;
  } babylon{};
  struct Three {
    double group_order = 0, render_order = 0;
    bool depth_test = true, depth_write = true, force_single_pass = false;
    bool operator==(const Three&) const = default;
  } three{};
  struct Panda3D {
    std::optional<std::string> bin{};  // set_bin(bin, draw_order)
    int draw_order = 0;
    bool depth_test = true, depth_write = true;
    bool operator==(const Panda3D&) const = default;
  } panda3d{};

  static constexpr std::uint32_t most_rendering_groups = 64;

  bool operator==(const EngineSettings&) const = default;
};

}  // namespace facetsort
