// The recordings in tests/engines/fixtures: their README says how a draw is written.
#pragma once

#include <fstream>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "facetsort/scene/object_draw.h"

namespace facetsort {

// Its "scenes"; null where there is no such file.
inline nlohmann::json read_scenes(const std::string& name) {
  std::ifstream file(std::string(FACETSORT_SOURCE_DIR) + "/tests/engines/fixtures/" + name + ".json");
  return file ? nlohmann::json::parse(file)["scenes"] : nlohmann::json();
}

inline glm::dvec3 vector_of(const nlohmann::json& numbers) {
  return {numbers.at(0), numbers.at(1), numbers.at(2)};
}

inline std::string text_of(const ObjectDraw& draw) {
  std::string text = std::to_string(draw.item);
  text += draw.faces == Faces::all ? 'a' : draw.faces == Faces::back ? 'b' : 'f';
  if (!draw.colour_write) text += 'p';
  if (!draw.depth_write) text += 'w';
  if (!draw.depth_test) text += 't';
  if (draw.clear_depth) text += 'c';
  if (draw.alpha_cutoff > 0) text += 'k';
  if (draw.transmission_pass) text += 'T';
  return text;
}

inline std::string text_of(std::span<const ObjectDraw> draws) {
  std::string text;
  for (const ObjectDraw& draw : draws) {
    if (!text.empty()) text += ' ';
    text += text_of(draw);
  }
  return text;
}

inline std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

}  // namespace facetsort
