// Work dealt to the lanes of a subgroup that are there: it need not be full.
#ifndef LATELIGHT_LANES_GLSL
#define LATELIGHT_LANES_GLSL
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_vote : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_shuffle : require

uint lanesPresent = 1u;  // how many
uint laneRank = 0u;      // this one's place among them, from 0

// Every invocation of the subgroup that will share work must call it.
void countLanes() {
  uvec4 present = subgroupBallot(true);
  lanesPresent = subgroupBallotBitCount(present);
  laneRank = subgroupBallotExclusiveBitCount(present);
}

// Ballots of 32 lanes are one word: GPUs index a vector by way of memory.
const bool kOneWord = kSubgroupSize <= 32u;
bool anyLane(uvec4 ballot) { return kOneWord ? ballot.x != 0u : any(notEqual(ballot, uvec4(0u))); }

// Takes the first lane out of a ballot.
uint popLane(inout uvec4 ballot) {
  uint lane = kOneWord ? uint(findLSB(ballot.x)) : subgroupBallotFindLSB(ballot);
  if (kOneWord)
    ballot.x &= ballot.x - 1u;
  else
    ballot[lane >> 5u] &= ~(1u << (lane & 31u));
  return lane;
}

// What a lane that all name has. lavapipe goes through all lanes for each broadcast, and shuffles by one instruction.
#define FROM_LANE(type) \
  type fromLane(type value, uint lane) { \
    return kCpuDevice != 0u ? subgroupShuffle(value, lane) : subgroupBroadcast(value, lane); \
  }
FROM_LANE(uint)
FROM_LANE(float)
FROM_LANE(vec3)
#endif
