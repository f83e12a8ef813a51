// Work dealt to the lanes of a subgroup that are there: it need not be full.
#ifndef LATELIGHT_LANES_GLSL
#define LATELIGHT_LANES_GLSL
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_vote : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require

uint lanesPresent = 1u;  // how many
uint laneRank = 0u;      // this one's place among them, from 0

// Every invocation of the subgroup that will share work must call it.
void countLanes() {
  uvec4 present = subgroupBallot(true);
  lanesPresent = subgroupBallotBitCount(present);
  laneRank = subgroupBallotExclusiveBitCount(present);
}
#endif
