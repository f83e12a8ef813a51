#version 460
#extension GL_GOOGLE_include_directive : require
// Temporal accumulation of indirect light (Schied et al. 2017, Spatiotemporal Variance-Guided Filtering, section 4.1):
// averages the signals of a frame with those of earlier frames, which motion vectors find, where these show the same
// surface. Inputs and the signals that it writes: indirect_filter.glsl. The history consists of the signals and of
// their surfaces, `lastSurface`: x: distance from the eye (bits of a float), y: octahedral normal, z: number of the
// instance, w: frames in the scattered and in the mirrored signal (half floats; 0: no surface).
//
// All samples of all frames count alike, up to kMaxFrames. From there on, older ones fade out. A signal's variance is
// that of all these samples, whose mean square follows from the signal itself.
#include "render/lighting/reference/indirect_filter.glsl"

layout(set = 0, binding = 6) uniform sampler2DArray motionOfSurfaces;  // MotionUse::Surfaces
layout(set = 0, binding = 7) uniform sampler2DArray lastScattered;
layout(set = 0, binding = 8) uniform sampler2DArray lastMirrored;
layout(set = 0, binding = 9) uniform usampler2DArray lastSurface;
layout(set = 0, binding = 10, rgba32ui) uniform writeonly uimage2DArray nextSurface;

const float kMaxFrames = 64.0;

// --- the history of a pixel ------------------------------------------------------------------------------------------

// The surface that the history of a pixel must show.
struct Expected {
  vec2 at;          // in pixels of the last frame
  float distance;   // from the last frame's eye, meters
  float tolerance;  // meters
  vec3 normal;
  uint instance;
};

float eyeDistance(View view, ivec3 place) {
  FilterSurface s = filterSurface(place);
  return s.some ? distance(s.position, view.eye) : 3.0e38;
}

// Returns by how much the distance from the eye changes to the next pixel of the same surface.
float distancePerPixel(View view, ivec3 place, float own) {
  ivec3 most = ivec3(textureSize(scatteredLight, 0).xy - 1, place.z);
  vec2 steps = vec2(3.0e38);
  for (int i = 0; i < 4; ++i) {
    int axis = i & 1;
    ivec3 at = place;
    at[axis] += (i & 2) != 0 ? 1 : -1;
    steps[axis] = min(steps[axis], abs(eyeDistance(view, clamp(at, ivec3(0, 0, place.z), most)) - own));
  }
  return max(steps.x, steps.y);
}

Expected expectedHistory(View view, ivec3 place, FilterSurface own, vec4 motion) {
  float here = distance(own.position, view.eye);
  Expected e;
  e.at = vec2(place.xy) + 0.5 + motion.xy;
  e.distance = here * motion.z;
  e.tolerance = 0.01 * e.distance + min(2.0 * distancePerPixel(view, place, here), 0.1 * e.distance);
  e.normal = own.normal;
  e.instance = uint(motion.w);
  return e;
}

// Returns the frames of the history at a pixel, or 0 if it shows another surface.
vec2 framesAt(ivec3 place, Expected e) {
  if (!inFrame(place.xy)) return vec2(0.0);
  uvec4 state = texelFetch(lastSurface, place, 0);
  bool same = state.w != 0u && state.z == e.instance &&
              abs(uintBitsToFloat(state.x) - e.distance) <= e.tolerance &&
              dot(directionFromOctahedral(unpackSnorm2x16(state.y)), e.normal) > 0.9;
  return same ? floatsFromHalves(state.w) : vec2(0.0);
}

// The mean square of the luminances of all samples in a signal.
float meanSquare(vec4 signal, float frames) {
  float mean = luminance(signal.rgb);
  return signal.a * max(frames * float(push.samples) - 1.0, 0.0) + mean * mean;
}

// w of the signals: meanSquare().
struct History {
  vec4 scattered, mirrored;
  vec2 frames;  // 0: there is none
};

History historyAt(Expected e, int layer) {
  vec2 corner = floor(e.at - 0.5), f = e.at - 0.5 - corner;
  History h = History(vec4(0.0), vec4(0.0), vec2(0.0));
  float sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    ivec2 side = ivec2(i & 1, i >> 1);
    ivec3 at = ivec3(ivec2(corner) + side, layer);
    float weight = (side.x == 1 ? f.x : 1.0 - f.x) * (side.y == 1 ? f.y : 1.0 - f.y);
    vec2 frames = weight > 0.0 ? framesAt(at, e) : vec2(0.0);
    if (frames.x <= 0.0) continue;
    vec4 scattered = texelFetch(lastScattered, at, 0), mirrored = texelFetch(lastMirrored, at, 0);
    h.scattered += weight * vec4(scattered.rgb, meanSquare(scattered, frames.x));
    h.mirrored += weight * vec4(mirrored.rgb, meanSquare(mirrored, frames.y));
    h.frames += weight * frames;
    sum += weight;
  }
  if (sum < 0.01) return History(vec4(0.0), vec4(0.0), vec2(0.0));
  return History(h.scattered / sum, h.mirrored / sum, h.frames / sum);
}

// --- how long the history stays valid --------------------------------------------------------------------------------

// Sums of differences between the frame and the history, over neighbors: of both signals.
struct Differences {
  vec2 sum, squares;
  float count;
};

// Returns the fraction of its frames that a history keeps. Where light has changed, the mean difference of the
// neighborhood exceeds its standard error by more than noise explains (Student's t).
vec2 agreement(Differences d) {
  if (d.count < 6.0) return vec2(1.0);
  vec2 mean = d.sum / d.count;
  vec2 variance = max(d.squares / d.count - mean * mean, vec2(0.0)) / (d.count - 1.0);
  vec2 excess = max(abs(mean) * inversesqrt(variance + 1e-20 + 1e-6 * mean * mean) - 3.0, vec2(0.0));
  return 1.0 / (1.0 + excess * excess);
}

Differences differencesAround(ivec3 place, FilterSurface own, Expected e) {
  const int kReach = 2, kStep = 3;
  Differences d = Differences(vec2(0.0), vec2(0.0), 0.0);
  ivec2 before = ivec2(floor(e.at));
  for (int i = 0; i < (2 * kReach + 1) * (2 * kReach + 1); ++i) {
    ivec2 offset = (ivec2(i % (2 * kReach + 1), i / (2 * kReach + 1)) - kReach) * kStep;
    ivec3 now = ivec3(place.xy + offset, place.z), last = ivec3(before + offset, place.z);
    if (!inFrame(now.xy) || !inFrame(last.xy)) continue;
    uvec4 state = texelFetch(lastSurface, last, 0);
    if (state.w == 0u || state.z != e.instance) continue;
    if (surfaceWeight(own, filterSurface(now), kScatteredSharpness) < 0.05) continue;
    vec2 difference = vec2(
        luminance(texelFetch(scatteredLight, now, 0).rgb) - luminance(texelFetch(lastScattered, last, 0).rgb),
        luminance(texelFetch(mirroredLight, now, 0).rgb) - luminance(texelFetch(lastMirrored, last, 0).rgb));
    d.sum += difference;
    d.squares += difference * difference;
    d.count += 1.0;
  }
  return d;
}

// Returns how many frames a reflection stays inside of the specular lobe, if the eye moves on as it did.
float mirroredFrames(View view, View last, FilterSurface own, float roughness) {
  float turn = length(normalize(view.eye - own.position) - normalize(last.eye - own.position));
  return turn > 1e-6 ? max(roughness * roughness, 0.0025) / turn : kMaxFrames;
}

// --- the new signals -------------------------------------------------------------------------------------------------

// `frames`: of the history.
vec4 accumulated(vec4 signal, vec4 history, float frames) {
  if (frames <= 0.0) return signal;
  vec4 sum = mix(history, vec4(signal.rgb, meanSquare(signal, 1.0)), 1.0 / (frames + 1.0));
  float mean = luminance(sum.rgb), count = (frames + 1.0) * float(push.samples);
  return vec4(sum.rgb, max(sum.a - mean * mean, 0.0) / max(count - 1.0, 1.0));
}

void main() {
  ivec3 place = ivec3(gl_GlobalInvocationID);
  if (!inFrame(place.xy)) return;
  FrameConstants frame = frameOf(push.frame, uint(place.z));
  View view = frameView(frame, uint(place.z));
  FilterSurface own = filterSurface(place);
  vec4 motion = texelFetch(motionOfSurfaces, place, 0);
  History h = History(vec4(0.0), vec4(0.0), vec2(0.0));
  if (own.some && push.frames > 0u) {
    Expected e = expectedHistory(view, place, own, motion);
    h = historyAt(e, place.z);
    if (h.frames.x > 0.0) h.frames *= agreement(differencesAround(place, own, e));
    h.frames = min(h.frames, vec2(kMaxFrames - 1.0));
    View last = viewAt(frame.previousViews, uint(place.z));
    h.frames.y = min(h.frames.y, mirroredFrames(view, last, own, texelFetch(scatteredAlbedo, place, 0).a));
  }
  vec4 scattered = texelFetch(scatteredLight, place, 0), mirrored = texelFetch(mirroredLight, place, 0);
  imageStore(filteredScattered, place, accumulated(scattered, h.scattered, h.frames.x));
  imageStore(filteredMirrored, place, accumulated(mirrored, h.mirrored, h.frames.y));
  uvec4 state = uvec4(floatBitsToUint(distance(own.position, view.eye)),
                      packSnorm2x16(octahedralFromDirection(own.normal)), uint(motion.w),
                      packHalf2x16(h.frames + 1.0));
  imageStore(nextSurface, place, own.some ? state : uvec4(0u));
}
