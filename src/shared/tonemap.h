// Tone mapping: maps linear Rec.709, any finite value >= 0, to linear display light in [0, 1]. The sRGB transfer
// function is applied afterward. All operators map black to black and are monotonic in gray.
#ifndef LATELIGHT_SHARED_TONEMAP_H
#define LATELIGHT_SHARED_TONEMAP_H

#include "shared/color.h"
#include "shared/lang.h"

SH_BEGIN

SH_CONST uint kTonemapKhronosNeutral = 0u;
SH_CONST uint kTonemapAces = 1u;
SH_CONST uint kTonemapAgx = 2u;
SH_CONST uint kTonemapReinhard = 3u;
SH_CONST uint kTonemapNone = 4u;

SH_FUNC vec3 saturateColor(vec3 c) {
  return vec3(saturate(c.x), saturate(c.y), saturate(c.z));
}

// Khronos PBR Neutral (KhronosGroup/ToneMapping, PBR_Neutral, 2024). Under gray light, base colors up to 0.8 are
// reproduced as authored, minus the 0.04 that a dielectric reflects (the toe removes it). Above, the peak is compressed
// and desaturated.
SH_FUNC vec3 tonemapKhronosNeutral(vec3 c) {
  float startCompression = 0.8f - 0.04f;
  float desaturation = 0.15f;
  float low = min(c.x, min(c.y, c.z));
  float toe = low < 0.08f ? low - 6.25f * low * low : 0.04f;
  c = c - vec3(toe, toe, toe);
  float peak = maxChannel(c);
  if (peak < startCompression) return c;
  float d = 1.0f - startCompression;
  float newPeak = 1.0f - d * d / (peak + d - startCompression);
  c = c * (newPeak / peak);
  float white = 1.0f - 1.0f / (desaturation * (peak - newPeak) + 1.0f);
  return c + (vec3(newPeak, newPeak, newPeak) - c) * white;
}

// One channel of Hill's fit of the ACES reference rendering transform and sRGB output transform.
SH_FUNC float acesCurve(float x) {
  return (x * (x + 0.0245786f) - 0.000090537f) / (x * (0.983729f * x + 0.4329510f) + 0.238081f);
}

// ACES by Stephen Hill's fit (in Pettineo and Hill, BakingLab, ACES.hlsl, 2016), without the exposure boost of 1/0.6
// that some renderers add. Rows: sRGB to AP1 with the RRT's saturation, and back with the ODT's.
SH_FUNC vec3 tonemapAces(vec3 c) {
  float r = acesCurve(dot(c, vec3(0.59719f, 0.35458f, 0.04823f)));
  float g = acesCurve(dot(c, vec3(0.07600f, 0.90834f, 0.01566f)));
  float b = acesCurve(dot(c, vec3(0.02840f, 0.13383f, 0.83777f)));
  vec3 t = vec3(r, g, b);
  return vec3(dot(t, vec3(1.60475f, -0.53108f, -0.07367f)), dot(t, vec3(-0.10208f, 1.10813f, -0.00605f)),
              dot(t, vec3(-0.00327f, -0.07276f, 1.07602f)));
}

// One channel of AgX: log2 between -12.47393 and 4.026069 stops to [0, 1], then the default contrast.
SH_FUNC float agxCurve(float x) {
  float t = saturate((log2(max(x, 1e-10f)) + 12.47393f) / (4.026069f + 12.47393f));
  return (((((15.5f * t - 40.14f) * t + 31.96f) * t - 6.868f) * t + 0.4298f) * t + 0.1191f) * t - 0.00232f;
}

// AgX (Sobotka 2022, default look) by Wrensch's fit (2023, Minimal AgX Implementation; mean squared error 3.7e-6):
// inset, curve, outset. The result is encoded for a display of exponent 2.2, so that exponent makes it linear.
SH_FUNC vec3 tonemapAgx(vec3 c) {
  float r = agxCurve(dot(c, vec3(0.842479062253094f, 0.0784335999999992f, 0.0792237451477643f)));
  float g = agxCurve(dot(c, vec3(0.0423282422610123f, 0.878468636469772f, 0.0791661274605434f)));
  float b = agxCurve(dot(c, vec3(0.0423756549057051f, 0.0784336f, 0.879142973793104f)));
  vec3 t = vec3(r, g, b);
  vec3 display = saturateColor(vec3(dot(t, vec3(1.19687900512017f, -0.0980208811401368f, -0.0990297440797205f)),
                                    dot(t, vec3(-0.0528968517574562f, 1.15190312990417f, -0.0989611768448433f)),
                                    dot(t, vec3(-0.0529716355144438f, -0.0980434501171241f, 1.15107367264116f))));
  return vec3(pow(display.x, 2.2f), pow(display.y, 2.2f), pow(display.z, 2.2f));
}

// Reinhard et al. 2002, equation 3, on luminance, which preserves hue. Channels that then exceed 1 are clipped.
SH_FUNC vec3 tonemapReinhard(vec3 c) {
  return c * (1.0f / (1.0f + luminance(c)));
}

// Applies the operator `op` (kTonemap*). Values above 65504, the largest half float, are clamped to 65504.
SH_FUNC vec3 tonemap(uint op, vec3 c) {
  c = vec3(clamp(c.x, 0.0f, 65504.0f), clamp(c.y, 0.0f, 65504.0f), clamp(c.z, 0.0f, 65504.0f));
  if (op == kTonemapKhronosNeutral) c = tonemapKhronosNeutral(c);
  if (op == kTonemapAces) c = tonemapAces(c);
  if (op == kTonemapAgx) c = tonemapAgx(c);
  if (op == kTonemapReinhard) c = tonemapReinhard(c);
  return saturateColor(c);
}

SH_END

#endif
