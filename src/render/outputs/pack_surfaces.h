// Packs data outputs of surfaces from images of the geometry pass (hardware raster): depth, and the words of the layout
// `exact` that the outputs consist of (data_words.h).
#pragma once

#include "render/frame/frame.h"
#include "render/outputs/pack_push.h"
#include "render/outputs/surface_outputs.h"

namespace latelight::render {

// Returns the words that these outputs are packed from, in groups of four: the constants of data_words.glsl. Empty if
// the outputs depend only on depth.
std::vector<uint32_t> dataWordsOf(const SurfaceOutputs& outputs);
// Appends these constants to those of a pipeline.
void addDataWords(std::span<const uint32_t> words, std::vector<vk::Constant>& constants);

// Makes a pass pack the outputs from `first` on, at most shared::kPackedAtOnce of them, into the slots of its push
// constants. Returns their places, with which setSlots() fills these. `filled`: the places hold backgrounds.
std::vector<ResultTarget> packInSlots(const SurfaceOutputs& outputs, size_t first, bool filled, ComputePass& pass);
void setSlots(std::span<const ResultTarget> places, graph::Context& context, shared::OutputSlot* slots);

// Adds the passes that give the outputs the values that they have where nothing is visible.
void addBackgrounds(const FrameContext& f, const VisibilityBuffer& visible, const SurfaceOutputs& outputs);

// Adds the passes that pack the outputs. `images` has one image per element of `words`, R32G32B32A32_UINT.
void addPackedSurfaces(const FrameContext& f, const VisibilityBuffer& visible, const SurfaceOutputs& outputs,
                       std::span<const uint32_t> words, std::span<const graph::ImageId> images);

}  // namespace latelight::render
