// Packs data outputs of surfaces from images of the geometry pass (hardware raster): depth, and the words of the layout
// `exact` that the outputs consist of (data_words.h).
#pragma once

#include "render/frame/frame.h"
#include "render/outputs/surface_outputs.h"

namespace latelight::render {

// Returns the words that these outputs are packed from, in groups of four: the constants of data_words.glsl. Empty if
// the outputs depend only on depth.
std::vector<uint32_t> dataWordsOf(const SurfaceOutputs& outputs);
// Appends these constants to those of a pipeline.
void addDataWords(std::span<const uint32_t> words, std::vector<vk::Constant>& constants);

// Adds the passes that fill the outputs with the values that they have where nothing is visible. Returns false, and
// adds none, if these depend on the view.
bool fillsBackgrounds(const FrameContext& f, const SurfaceOutputs& outputs);

// Adds the passes that pack the outputs. `images` has one image per element of `words`, R32G32B32A32_UINT.
void addPackedSurfaces(const FrameContext& f, const VisibilityBuffer& visible, const SurfaceOutputs& outputs,
                       std::span<const uint32_t> words, std::span<const graph::ImageId> images);

}  // namespace latelight::render
