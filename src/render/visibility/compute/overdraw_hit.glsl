// Overdraw: counts the triangles per pixel, in the visibility buffer's memory. Include after raster.glsl.
void hit(uint view, ivec2 pixel, uint samples, PixelDepth depth, uint id) {
  atomicAdd(VisibleRef(push.buffers.visible).v[visibleIndex(uvec3(pixel, view), uvec2(push.width, push.height))],
            uint64_t(1));
}
