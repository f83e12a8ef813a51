// Textures from a function of position: the base color, normal, and roughness with metalness of one surface.
#pragma once

#include <functional>
#include <string>

#include "scene/textures/texture.h"

namespace latelight::scene::builtin {

struct MapTexel {
  vec3 color{0.5f};  // sRGB-encoded
  float height = 0;  // in texels; its slopes become the normal map
  vec2 tilt{0};      // added to the normal's x and y
  float roughness = 1;
  float metallic = 0;
};

struct SurfaceMaps {
  int color = -1, normal = -1, roughness = -1;  // indices into Scene::textures; -1: not requested
};

// `texel` receives the position in [0, 1)^2, y down, and is called on all threads. The maps tile if the function does.
// `slots` selects the material slots whose maps are generated (LoadOptions::textureSlots).
SurfaceMaps addMaps(Scene& scene, const std::string& name, ImageSize size, const std::function<MapTexel(vec2)>& texel,
                    uint32_t slots);
// Adds only a color map.
int addColorMap(Scene& scene, const std::string& name, ImageSize size, const std::function<vec3(vec2)>& color);

}  // namespace latelight::scene::builtin
