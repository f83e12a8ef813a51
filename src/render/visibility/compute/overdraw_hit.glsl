// Counts what covers a pixel, in the place of what is visible there. After raster.glsl.
void hit(uint view, ivec2 pixel, uint samples, PixelDepth depth, uint id) {
  atomicAdd(VisibleRef(push.buffers.visible).v[visibleIndex(uvec3(pixel, view), uvec2(push.width, push.height))],
            uint64_t(1));
}
