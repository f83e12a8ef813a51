// Small glTF files that use what the renderer reads, made by the tests: nothing is stored, and no package is needed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace latelight::app {

using Bytes = std::vector<std::byte>;

// A tiled floor, a back wall and spheres under a directional, a point with a range, and a spot light. Camera "front".
Bytes punctualModel();

// Every texture slot: a floor with base colour, normal map and texture transform; a sphere with a metal-roughness
// picture and vertex colours; a card cut out by alpha; a card that glows by an emissive picture; a card that is unlit.
// Two cameras: "front", "above/orthographic". No light.
Bytes texturedModel();

// How the pictures of texturedModel() are stored.
enum class PictureKind { Png, Jpeg, Webp };
Bytes texturedModel(PictureKind kind);

// What few files use: sparse accessors, quantised and normalised attributes, a strip, a fan, GPU instancing, variants,
// a mirrored node, and buffer views compressed by EXT_meshopt_compression.
Bytes intricateModel();

// The same scene as one .gltf with a data URI.
std::string embeddedModel();

// Panoramas of a sky with a bright sun: as Radiance (new run lengths) and as OpenEXR.
Bytes radiancePanorama(uint32_t width, uint32_t height);
Bytes exrPanorama(uint32_t width, uint32_t height);

}  // namespace latelight::app
