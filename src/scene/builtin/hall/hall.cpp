#include "scene/builtin/make.h"
#include "scene/builtin/scene_builder.h"

namespace latelight::scene::builtin {

// The hall's floor: what stands on it follows.
Scene makeHall(uint64_t triangles, uint32_t lights, uint64_t seed) {
  SceneBuilder builder("hall");
  Mesh floor;
  floor.name = "floor";
  for (const vec2 p : {vec2(-9, 21), vec2(9, 21), vec2(9, -21), vec2(-9, -21)}) {
    floor.positions.push_back({p.x, 0, p.y});
    floor.attributes.push_back({{0, 1, 0}, {1, 0, 0, 1}, {p.x, p.y}});
  }
  floor.indices = {0, 1, 2, 0, 2, 3};
  computeBounds(floor);
  builder.scene.meshes.push_back(std::move(floor));
  builder.scene.materials.push_back(plainMaterial("marble", vec3(0.6f), 0, 0.3f));
  builder.addInstance("floor", SceneBuilder::kRoot, 0, 0);
  for (uint32_t i = 0; i < lights; ++i) {
    Light light;
    light.name = "lantern";
    light.intensity = 200.0f / float(lights);
    light.position = {0, 18 - 36 * (float(i) + 0.5f) / float(lights), 4};
    builder.scene.lights.push_back(light);
  }
  builder.addCamera("main", {-1.6f, 1.7f, 19}, {0.6f, 3, -20}, 0.95f, 0.05f);
  return std::move(builder.scene);
}

}  // namespace latelight::scene::builtin
