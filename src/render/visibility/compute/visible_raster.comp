#version 460
#extension GL_GOOGLE_include_directive : require
// Data outputs about rasterization: the instance, cluster and triangle visible at each pixel, and its size class, which
// is computed again from its corners.
#include "render/visibility/compute/raster.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0, rgba32f) writeonly uniform image2DArray numbers;  // instance + 1, cluster, triangle
layout(set = 0, binding = 1, rg32f) writeonly uniform image2DArray classes;    // kRaster*, and facing()

// Returns the cosine between the triangle's normal and the ray through the pixel's center.
float facing(View view, vec3 a, vec3 b, vec3 c, ivec2 pixel) {
  vec3 normal = cross(b - a, c - a), ray = viewRay(view.projection, pixelToNdc(vec2(pixel) + 0.5, view.size));
  return abs(dot(normal, ray)) / max(length(normal) * length(ray), 1e-37);
}

vec2 classOf(FrameConstants frame, View view, VisibleTriangle seen, ivec2 pixel) {
  mat4x3 placed = relativeToEye(frameInstance(frame, seen.draw.instance), view);
  uint64_t positions = frameMesh(frame, seen.draw.mesh).positions;
  Corner a = cornerAt(view, placed, positionAt(positions, seen.indices.x));
  Corner b = cornerAt(view, placed, positionAt(positions, seen.indices.y));
  Corner c = cornerAt(view, placed, positionAt(positions, seen.indices.z));
  float turned = facing(view, a.seen, b.seen, c.seen, pixel);
  if ((seen.draw.flags & kDrawVast) != 0u || ((a.outside | b.outside | c.outside) & kOutsideVolume) != 0u)
    return vec2(float(kRasterClipped), turned);
  Triangle t = Triangle(a.screen, b.screen, c.screen, vec3(0.0), 0.0, 0.0, 0u);
  return vec2(float(sizeClass(t, onScreen(pixelsOf(t)))), turned);
}

uint clusterOf(FrameConstants frame, VisibleTriangle seen) {
  return UintRef(frameMesh(frame, seen.draw.mesh).clusters.clusterOfTriangle).v[seen.number];
}

void main() {
  ivec3 size = imageSize(numbers), pixel = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(pixel, size))) return;
  uint id = visibleId(VisibleRef(push.buffers.visible).v[visibleIndex(uvec3(pixel), uvec2(size.xy))]);
  if (id == 0u) {
    imageStore(numbers, pixel, vec4(0.0));
    imageStore(classes, pixel, vec4(0.0));
    return;
  }
  FrameConstants frame = frameOf(push.buffers.frame, gl_WorkGroupID.z);
  VisibleTriangle seen = visibleTriangle(frame, push.buffers.instances, id);
  imageStore(numbers, pixel,
             vec4(float(seen.draw.instance + 1u), float(clusterOf(frame, seen)), float(seen.number), 0.0));
  imageStore(classes, pixel, vec4(classOf(frame, frameView(frame, uint(pixel.z)), seen, pixel.xy), 0.0, 0.0));
}
