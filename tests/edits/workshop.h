// Helpers for the tests of edits: a small scene with every kind of material, light and instance, and comparisons of
// frames.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "render/support.h"

namespace latelight::render::test {

// A floor, spheres and cards: opaque, masked, blended, double-sided, unlit and emissive ones, some of them mirrored,
// under a directional, a point and a spot light. Three textures, in the slots for base color, metallic-roughness and
// emission.
scene::Scene workshop();
scene::Camera workshopCamera();

// Settings for a small picture of it with shadows and all data outputs.
Settings workshopSettings();

// Returns the same scene without its gaps, as if the removed elements had never existed.
scene::Scene withoutGaps(const scene::Scene& scene);

// Random numbers that do not depend on the standard library.
class Dice {
 public:
  explicit Dice(uint32_t seed) : engine_(seed) {}
  uint32_t below(uint32_t count) { return static_cast<uint32_t>(engine_() % count); }
  bool chance(float share) { return unit() < share; }
  float unit() { return static_cast<float>(engine_() >> 8) * 0x1p-24f; }
  float between(float low, float high) { return low + (high - low) * unit(); }
  glm::vec3 inside(glm::vec3 low, glm::vec3 high) {
    const float x = unit(), y = unit(), z = unit();
    return low + (high - low) * glm::vec3(x, y, z);
  }

 private:
  std::mt19937 engine_;
};

// Adds failures that name the outputs of two frames that differ, and the position of the first difference.
void expectSame(const output::FrameOutput& actual, const output::FrameOutput& expected);

// Compares a frame of the renderer with that of a new renderer.
void expectAsFresh(Renderer& renderer, vk::Device& device, const scene::Scene& scene, const Settings& settings,
                   const scene::Environment* environment = nullptr, const SceneState& moment = {});

}  // namespace latelight::render::test
