// Writes lights: KHR_lights_punctual, and area lights as extras of their nodes.
#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <utility>

#include "export/document_nodes.h"
#include "scene/light_types.h"
#include "shared/light.h"

namespace latelight::exports {

using namespace scene;

namespace {

// The outer angle is above 0 and at most a right angle, which floats round up, and the inner angle is below it
// (KHR_lights_punctual). The largest float below the outer angle has the same cosine, up to rounding.
Json describeCone(const Light& light) {
  const float outer = std::clamp(light.outerCone, std::numeric_limits<float>::min(), glm::half_pi<float>());
  const float inner = std::min(light.innerCone, std::nextafter(outer, 0.0f));
  return {{"innerConeAngle", shortest(inner)}, {"outerConeAngle", std::min(shortest(outer), M_PI / 2)}};
}

// glTF's colors are at most 1. The divisor of others is a power of two, so that the product with the intensity is
// exact.
Json describeLight(const Light& light) {
  const float largest = std::max({light.color.x, light.color.y, light.color.z});
  const float divisor = largest > 1 ? std::exp2(std::ceil(std::log2(largest))) : 1;
  Json out{{"type", lightTypes()[light.type].name}, {"intensity", shortest(light.intensity * divisor)}};
  if (!light.name.empty()) out["name"] = light.name;
  if (light.color != vec3(1)) out["color"] = arrayOf(light.color / divisor);
  if (light.range) out["range"] = shortest(*light.range);
  if (shared::lightHasCone(light.type)) out["spot"] = describeCone(light);
  const bool isDirectional = shared::lightIsDirectional(light.type);
  if (light.size > 0)
    objectIn(out, "extras")[isDirectional ? "angle" : "radius"] =
        isDirectional ? double{light.size} * 180 / M_PI : shortest(light.size);
  if (light.castShadow) objectIn(out, "extras")["castShadow"] = *light.castShadow;
  return out;
}

// The extras of scene/gltf/area_lights.h.
Json describeArea(const Light& light) {
  const bool isRect = light.type == shared::kLightRect;
  const double size = isRect ? shortest(light.height) : 2 * shortest(light.size);
  Json out{{"type", lightTypes()[light.type].name}, {"intensity", shortest(light.intensity)}, {"size", size}};
  if (!light.name.empty()) out["name"] = light.name;
  if (light.color != vec3(1)) out["color"] = arrayOf(light.color);
  if (isRect && light.width != light.height) objectIn(out, "rect")["aspect"] = light.width / size;
  if (light.type == shared::kLightTube) objectIn(out, "tube")["length"] = shortest(light.length);
  if (light.twoSided) out["twoSided"] = true;
  if (light.castShadow) out["castShadow"] = *light.castShadow;
  return out;
}

// Returns the light's node if that places it, hides it as it is hidden at rest, and has no other light; otherwise a
// new node.
int nodeOfLight(DocumentNodes& nodes, const Light& light) {
  const int own = light.node >= 0 ? nodes.ofScene[size_t(light.node)] : -1;
  const bool isArea = shared::lightIsArea(light.type);
  const auto kept = isArea ? "/extras/areaLight"_json_pointer : "/extensions/KHR_lights_punctual"_json_pointer;
  if (own >= 0 && light.hidden == nodes.isHidden[size_t(light.node)] && !nodes.at(own).contains(kept)) {
    Light placed = light;
    placeLight(placed, nodes.placeInFile(light.node));
    if (placed == light) return own;
  }
  const dvec3 position(toGltfFromWorld() * glm::dvec4(light.position, 1));
  if (isArea) {
    dmat4 place = toGltfFromWorld() * dmat4(glm::dmat3(light.axes));
    place[3] = glm::dvec4(position, 1);
    Json node{{"name", light.name.empty() ? "light" : light.name}};
    setTransform(node, place, dvec3(1));
    if (light.hidden) nodes.hide(node);
    return nodes.add(std::move(node), -1);
  }
  const dvec3 back = -glm::normalize(dvec3(toGltfFromWorld() * glm::dvec4(light.direction, 0)));
  const dvec3 side = glm::normalize(glm::cross(std::abs(back.y) < 0.9 ? dvec3(0, 1, 0) : dvec3(1, 0, 0), back));
  Json node{{"name", light.name.empty() ? "light" : light.name}};
  setMatrix(node, dmat4(glm::dvec4(side, 0), glm::dvec4(glm::cross(back, side), 0), glm::dvec4(back, 0),
                        glm::dvec4(position, 1)));
  if (light.hidden) nodes.hide(node);
  return nodes.add(std::move(node), -1);
}

}  // namespace

void addLights(const Scene& scene, DocumentNodes& nodes, std::vector<int>& indices) {
  indices.assign(scene.lights.size(), -1);
  for (size_t i = 0; i < scene.lights.size(); ++i) {
    const Light& light = scene.lights[i];
    if (light.removed) continue;
    if (shared::lightIsArea(light.type)) {
      objectIn(nodes.at(nodeOfLight(nodes, light)), "extras")["areaLight"] = describeArea(light);
      continue;
    }
    Json& lights = arrayIn(nodes.document.extension(nodes.document.root, "KHR_lights_punctual"), "lights");
    indices[i] = static_cast<int>(lights.size());
    lights.push_back(describeLight(light));
    Json& node = nodes.at(nodeOfLight(nodes, light));
    nodes.document.extension(node, "KHR_lights_punctual")["light"] = indices[i];
  }
}

}  // namespace latelight::exports
