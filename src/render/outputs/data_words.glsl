// The words of the layout `exact` that data outputs are packed from, four per image: geometry_data.frag writes them,
// and pack_surfaces.comp reads them. Include before the layout that the shader is compiled for.
#ifndef LATELIGHT_DATA_WORDS_GLSL
#define LATELIGHT_DATA_WORDS_GLSL
#include "render/outputs/exact_targets.glsl"
#include "render/outputs/data_words.h"

// The words of each image (dataWordsOf() of pack_surfaces.h).
layout(constant_id = kFirstDataWordsConstant + 0) const uint kDataWords0 = kNoDataWords;
layout(constant_id = kFirstDataWordsConstant + 1) const uint kDataWords1 = kNoDataWords;
layout(constant_id = kFirstDataWordsConstant + 2) const uint kDataWords2 = kNoDataWords;
layout(constant_id = kFirstDataWordsConstant + 3) const uint kDataWords3 = kNoDataWords;
layout(constant_id = kFirstDataWordsConstant + 4) const uint kDataWords4 = kNoDataWords;
layout(constant_id = kFirstDataWordsConstant + 5) const uint kDataWords5 = kNoDataWords;

uint exactWord(ExactTargets targets, uint word) {
  return word == kNoDataWord ? 0u : targets.v[word >> 2u][word & 3u];
}
uvec4 exactWords(ExactTargets targets, uint words) {
  return uvec4(exactWord(targets, words & 255u), exactWord(targets, words >> 8u & 255u),
               exactWord(targets, words >> 16u & 255u), exactWord(targets, words >> 24u));
}
void setExactWord(inout ExactTargets targets, uint word, uint value) {
  if (word != kNoDataWord) targets.v[word >> 2u][word & 3u] = value;
}
void setExactWords(inout ExactTargets targets, uint words, uvec4 values) {
  setExactWord(targets, words & 255u, values.x);
  setExactWord(targets, words >> 8u & 255u, values.y);
  setExactWord(targets, words >> 16u & 255u, values.z);
  setExactWord(targets, words >> 24u, values.w);
}

#endif
