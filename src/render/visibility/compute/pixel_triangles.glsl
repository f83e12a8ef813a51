// The visible triangles of a pixel's samples. Include after visible.glsl and setup.glsl; `first` is the pixel's
// visibleIndex().

uint coveredSamples(VisibleRef visible, uint first) {
  uint covered = 0u;
  for (uint i = 0u; i < kSamples; ++i) covered |= visible.v[first + i] != uint64_t(0) ? 1u << i : 0u;
  return covered;
}

// Returns the samples that show the same triangle as sample `index`. With kEverySample each sample counts separately.
uint samplesWith(VisibleRef visible, uint first, uint index) {
  if (kEverySample != 0u) return 1u << index;
  uint id = visibleId(visible.v[first + index]), samples = 0u;
  for (uint i = 0u; i < kSamples; ++i) samples |= visibleId(visible.v[first + i]) == id ? 1u << i : 0u;
  return samples;
}

// Returns the samples of the next triangle and removes them from `left`. Returns 0 if `left` is empty.
uint nextTriangle(VisibleRef visible, uint first, inout uint left) {
  if (left == 0u) return 0u;
  uint samples = samplesWith(visible, first, uint(findLSB(left)));
  left &= ~samples;
  return samples;
}
