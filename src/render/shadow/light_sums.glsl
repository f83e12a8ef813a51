// The light that several passes add to each pixel, one after the other. The lit picture stores half floats, to which
// some devices round down, so that each pass that adds to it would lose light. The passes therefore add 32-bit floats,
// and the last one adds the sum to the picture. Include after the declaration of `push`.
#ifndef LATELIGHT_LIGHT_SUMS_GLSL
#define LATELIGHT_LIGHT_SUMS_GLSL

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer LightSumsRef { vec3 v[]; };

int sumIndex(ivec3 place) {
  ivec2 size = imageSize(lightTarget).xy;
  return (place.z * size.y + place.y) * size.x + place.x;
}

// Returns the light of the passes before this one.
vec3 lightBefore(ivec3 place) {
  return push.first > 0u ? LightSumsRef(push.sums).v[sumIndex(place)] : vec3(0.0);
}

// Adds the light of all passes to the picture, if this is the last one.
void addLight(FrameConstants frame, ivec3 place, vec3 radiance) {
  if (push.end < push.count) {
    LightSumsRef(push.sums).v[sumIndex(place)] = radiance;
    return;
  }
  vec4 before = imageLoad(lightTarget, place);
  imageStore(lightTarget, place, vec4(min(before.rgb + radiance * frame.exposure, vec3(65504.0)), before.a));
}

#endif
