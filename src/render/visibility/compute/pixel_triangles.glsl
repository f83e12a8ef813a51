// The triangles that a pixel's samples show. After visible.glsl and setup.glsl; `first` is the pixel's visibleIndex().

uint coveredSamples(VisibleRef visible, uint first) {
  uint covered = 0u;
  for (uint i = 0u; i < kSamples; ++i) covered |= visible.v[first + i] != uint64_t(0) ? 1u << i : 0u;
  return covered;
}

// The samples that show what this one shows: with kEverySample each is on its own.
uint samplesWith(VisibleRef visible, uint first, uint index) {
  if (kEverySample != 0u) return 1u << index;
  uint id = visibleId(visible.v[first + index]), samples = 0u;
  for (uint i = 0u; i < kSamples; ++i) samples |= visibleId(visible.v[first + i]) == id ? 1u << i : 0u;
  return samples;
}

// Takes the samples of the next triangle out of `left`; none are left: none.
uint nextTriangle(VisibleRef visible, uint first, inout uint left) {
  if (left == 0u) return 0u;
  uint samples = samplesWith(visible, first, uint(findLSB(left)));
  left &= ~samples;
  return samples;
}
