// A file that uses most of the importer, for tests with damaged files.
#pragma once

#include "gltf_builder.h"

namespace latelight::scene::test {

// Nodes, sparse accessors, skins, morph targets, cameras, lights, instancing.
inline GltfBuilder busyFile() {
  GltfBuilder b = triangleFile();
  json& attributes = b.primitive()["attributes"];
  attributes["NORMAL"] = b.vectors(std::vector<vec3>(3, vec3(0, 0, 1)));
  attributes["COLOR_0"] = b.vectors(std::vector<vec4>(3, vec4(1)));
  attributes["JOINTS_0"] = b.accessor(b.view(std::vector<uint8_t>(12)), kUnsignedByte, "VEC4", 3);
  attributes["WEIGHTS_0"] = b.vectors(std::vector<vec4>(3, vec4(1, 0, 0, 0)));
  b.primitive()["indices"] = b.accessor(b.view(std::vector<uint16_t>{0, 1, 2}), kUnsignedShort, "SCALAR", 3);
  b.primitive()["targets"] = {{{"POSITION", attributes["POSITION"]}}};
  b.root["meshes"][0]["weights"] = {.5};
  int indices = b.view(std::vector<uint8_t>{1});
  int values = b.view(std::vector<vec3>{{2, 0, 0}});
  b.root["accessors"][0]["sparse"] = {{"count", 1},
                                      {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                                      {"values", {{"bufferView", values}}}};
  int inverse = b.accessor(b.view(std::vector<mat4>{mat4(1)}), kFloat, "MAT4", 1);
  b.add("skins", {{"joints", {1}}, {"inverseBindMatrices", inverse}});
  b.root["nodes"][0]["skin"] = 0;
  int times = b.accessor(b.view(std::vector<float>{0, 1}), kFloat, "SCALAR", 2);
  int turns = b.vectors(std::vector<vec4>{{0, 0, 0, 1}, {0, 1, 0, 0}});
  int bends = b.accessor(b.view(std::vector<float>{0, 0, 0, 1, 1, 1}), kFloat, "SCALAR", 6);
  b.add("animations", {{"channels",
                        {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "rotation"}}}},
                         {{"sampler", 1}, {"target", {{"node", 0}, {"path", "weights"}}}}}},
                       {"samplers",
                        {{{"input", times}, {"output", turns}},
                         {{"input", times}, {"output", bends}, {"interpolation", "CUBICSPLINE"}}}}});
  b.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", .7}, {"znear", .1}}}});
  b.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "spot"}, {"spot", {{"innerConeAngle", .1}}}}};
  b.root["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "a"}}};
  b.node({{"camera", 0}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}, {"children", {2}}});
  int many = b.positions({{1, 0, 0}, {2, 0, 0}});
  b.add("nodes",
        {{"mesh", 0}, {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", many}}}}}}}});
  b.add("materials",
        {{"pbrMetallicRoughness", {{"metallicFactor", .5}}}, {"extensions", {{"KHR_materials_ior", {{"ior", 1.4}}}}}});
  b.primitive()["material"] = 0;
  b.primitive()["extensions"]["KHR_materials_variants"]["mappings"] = {{{"material", 0}, {"variants", {0}}}};
  return b;
}

}  // namespace latelight::scene::test
