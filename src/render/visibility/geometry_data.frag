#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout, textured
// The geometry pass (geometry.glsl) of a picture with one sample per pixel, together with that of the data outputs.
#define ONE_SAMPLE
#define DATA_WORDS
#define DRAW_NUMBERS
#include "render/glsl/common.glsl"
#include "render/glsl/multisample.glsl"
#include "render/visibility/varyings.glsl"
#include "render/visibility/surface_fragment.glsl"
#include "render/outputs/data_words.glsl"
#include "render/glsl/gbuffer_write.glsl"
#include "render/visibility/geometry.glsl"
