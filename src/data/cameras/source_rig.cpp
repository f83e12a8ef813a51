// The camera sources "stereo" and "rig": several cameras at fixed offsets from each camera of another source.
#include <algorithm>
#include <optional>

#include "data/cameras/cameras.h"
#include "data/cameras/optics.h"
#include "data/cameras/pose_spec.h"
#include "data/cameras/source.h"

namespace latelight::data {

namespace {

struct Member {
  std::string name;
  glm::dmat4 offset{1};            // member's to base camera's frame, both in OpenCV's convention
  std::optional<Optics> optics{};  // empty: the base camera's optics
  CameraExposure exposure{};       // the values that are empty are those of the base camera
};

// Creates all members at each base camera. The neighbors of a member are the same member at the neighboring poses.
std::vector<Shot> shotsOfMembers(const std::vector<Shot>& bases, const std::vector<Member>& members) {
  std::vector<Shot> shots;
  shots.reserve(bases.size() * members.size());
  for (const Shot& base : bases)
    for (size_t number = 0; number < members.size(); ++number) {
      const Member& member = members[number];
      Shot shot = base;
      shot.name = memberName(base.name, member.name);
      shot.member = base.member.empty() ? member.name : memberName(base.member, member.name);
      shot.pose = base.pose * member.offset;
      if (shot.sequence)
        for (std::optional<size_t>* neighbor : {&shot.sequence->previous, &shot.sequence->next})
          if (*neighbor) *neighbor = **neighbor * members.size() + number;
      if (member.optics) {
        shot.optics = member.optics->camera;
        shot.width = member.optics->width, shot.height = member.optics->height;
      }
      shot.exposure = combined(member.exposure, base.exposure);
      shots.push_back(std::move(shot));
    }
  return shots;
}

std::vector<Shot> readBases(Spec& spec, const CameraContext& context, const std::vector<Member>& members) {
  CameraContext within = context;
  size_t longest = 0;
  for (const Member& member : members) longest = std::max(longest, member.name.size());
  within.copies *= double(members.size());
  within.nameBytes += double(longest + 1);
  return makeShots(spec.at("cameras"), spec.pathOf("cameras"), within);
}

Member readMember(Spec& spec, const CameraContext& context) {
  Member member{.name = spec.text("name")};
  if (spec.has("pose"))
    member.offset = readPoseMatrix(spec);
  else
    member.offset[3] = glm::dvec4(spec.vector("translation"), 1);
  if (hasOptics(spec)) member.optics = readOptics(spec, context.size);
  member.exposure = readExposure(spec);
  spec.finish();
  return member;
}

}  // namespace

std::vector<Shot> shotsOfStereo(Spec& spec, const CameraContext& context) {
  Member left{.name = "left"}, right{.name = "right"};
  right.offset[3].x = spec.number("baseline", kPositive);
  const std::vector<Member> members{left, right};
  return shotsOfMembers(readBases(spec, context, members), members);
}

std::vector<Shot> shotsOfRig(Spec& spec, const CameraContext& context) {
  std::vector<Member> members;
  for (Spec& member : spec.objects("offsets")) members.push_back(readMember(member, context));
  return shotsOfMembers(readBases(spec, context, members), members);
}

}  // namespace latelight::data
