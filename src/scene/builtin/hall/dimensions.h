// The hall's dimensions, in meters in its own frame: Y up, the nave along Z, the apse at -Z, the door at +Z. Dimensions
// that position pieces are multiples of 1/16, so that copies translated in floats meet exactly.
#pragma once

namespace latelight::scene::builtin::hall {

inline constexpr int kBays = 9;
inline constexpr double kBay = 4.5;
inline constexpr double kHalfLength = kBays * kBay / 2;  // the end walls' faces

// The arcade between nave and aisle.
inline constexpr double kColumnX = 4.25;
inline constexpr double kWallHalf = 0.3125;  // half the thickness of the arcade wall
inline constexpr double kNaveX = kColumnX - kWallHalf;
inline constexpr double kColumnRadius = 0.36;
inline constexpr double kColumnTop = 4.5;   // top of the abacus
inline constexpr double kArchSpring = 5.0;  // on top of the impost blocks
inline constexpr double kArchRadius = 1.875;
inline constexpr double kArcadeTop = 7.5;

// The floor: patterned up to kFloorX, plain under the arcade, and the aisle's pattern from kAisleFloorX on.
inline constexpr double kFloorX = 3.6875, kAisleFloorX = 4.8125;

// The gallery above the aisle.
inline constexpr double kGalleryFloor = 7.875;
inline constexpr double kBalustradeTop = 8.8125;
inline constexpr double kGallerySpring = 10.3125;
inline constexpr double kGalleryArchRadius = 0.5625;
inline constexpr double kGalleryPitch = kBay / 3;
inline constexpr double kGalleryTop = 11.375;

// The nave's barrel vault.
inline constexpr double kVaultSpring = 11.8125;
inline constexpr double kVaultRadius = kNaveX;

// The aisle.
inline constexpr double kOuterX = 8.5625;  // face of the outer wall
inline constexpr double kAisleX = (kColumnX + kWallHalf + kOuterX) / 2;
inline constexpr double kAisleHalf = (kOuterX - kColumnX - kWallHalf) / 2;
inline constexpr double kAisleRise = 2.0;  // height of the groin vault above kArchSpring
inline constexpr double kWindowSill = 2.0, kWindowSpring = 4.0, kWindowRadius = 0.75;

// The apse, and the door at the opposite end.
inline constexpr double kApseRadius = 3.0, kApseSpring = 6.5;
inline constexpr double kApseStep = 0.1875;  // height of each step
inline constexpr int kApseSteps = 3;
inline constexpr double kDoorRadius = 1.5, kDoorSpring = 3.5;
inline constexpr double kRoseRadius = 1.375, kRoseHeight = 13.5;

}  // namespace latelight::scene::builtin::hall
