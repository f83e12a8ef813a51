// Work distribution over the active lanes of a subgroup, which need not be full.
#ifndef LATELIGHT_LANES_GLSL
#define LATELIGHT_LANES_GLSL
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_vote : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_shuffle : require

uint lanesPresent = 1u;  // number of active lanes
uint laneRank = 0u;      // index of this lane among them

// Counts the active lanes. Every invocation of the subgroup that shares work must call it.
void countLanes() {
  uvec4 present = subgroupBallot(true);
  lanesPresent = subgroupBallotBitCount(present);
  laneRank = subgroupBallotExclusiveBitCount(present);
}

// Ballots of up to 32 lanes use one word, because GPUs index vectors through memory.
const bool kOneWord = kSubgroupSize <= 32u;
bool anyLane(uvec4 ballot) { return kOneWord ? ballot.x != 0u : any(notEqual(ballot, uvec4(0u))); }

// Removes the first lane from a ballot and returns it.
uint popLane(inout uvec4 ballot) {
  uint lane = kOneWord ? uint(findLSB(ballot.x)) : subgroupBallotFindLSB(ballot);
  if (kOneWord)
    ballot.x &= ballot.x - 1u;
  else
    ballot[lane >> 5u] &= ~(1u << (lane & 31u));
  return lane;
}

// Returns the value of a lane that is the same for all. On lavapipe a broadcast loops over all lanes, but a shuffle is
// one instruction.
#define FROM_LANE(type) \
  type fromLane(type value, uint lane) { \
    return kCpuDevice != 0u ? subgroupShuffle(value, lane) : subgroupBroadcast(value, lane); \
  }
FROM_LANE(uint)
FROM_LANE(float)
FROM_LANE(vec3)
#endif
