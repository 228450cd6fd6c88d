#include "haptic_core/world/world.h"

#include <cmath>

#include "haptic_core/base/error.h"
#include "haptic_core/world/pipeline.h"

namespace haptic {

struct World::Impl {
  explicit Impl(const WorldDef& definition) : def(definition), pipeline(definition) {}
  WorldDef def;
  Pipeline pipeline;
};

World::World(const WorldDef& def) : impl_(std::make_unique<Impl>(def)) {}
World::~World() = default;

void World::step() noexcept { impl_->pipeline.step(); }
void World::measureStages(bool on) noexcept { impl_->pipeline.measureStages(on); }
const WorldSettings& World::settings() const { return impl_->def.settings; }
const StepReport& World::report() const { return impl_->pipeline.report(); }
double World::time() const { return impl_->pipeline.state().time; }

int World::linkCount() const { return static_cast<int>(impl_->pipeline.plan().links.size()); }
const std::string& World::linkName(int link) const { return impl_->pipeline.plan().links[link].name; }
int World::linkIndex(const std::string& name) const {
  for (int i = 0; i < linkCount(); ++i) {
    if (linkName(i) == name) return i;
  }
  return -1;
}
Pose World::linkPose(int link) const { return impl_->pipeline.link(link).X_WL; }
Twist World::linkTwist(int link) const { return impl_->pipeline.link(link).twistAtOrigin(); }

int World::jointCount() const { return static_cast<int>(impl_->pipeline.plan().joints.size()); }
const std::string& World::jointName(int joint) const { return impl_->pipeline.plan().joints[joint].name; }
int World::jointIndex(const std::string& name) const {
  for (int i = 0; i < jointCount(); ++i) {
    if (jointName(i) == name) return i;
  }
  return -1;
}
int World::jointLink(int joint) const { return impl_->pipeline.plan().joints[joint].link; }
bool World::obeysCommands(int joint) const { return impl_->pipeline.plan().joints[joint].driven; }
JointReading World::joint(int joint) const noexcept { return impl_->pipeline.joint(joint); }
bool World::setJointCommand(int joint, const JointCommand& command) noexcept {
  return impl_->pipeline.setJointCommand(joint, command);
}

int World::pointerCount() const { return static_cast<int>(impl_->def.pointers.size()); }
const PointerDef& World::pointer(int i) const { return impl_->def.pointers[i]; }
int World::pointerLink(int i) const { return static_cast<int>(impl_->pipeline.state().pointers[i].link); }
void World::setPointerTarget(int i, const Pose& X_WL, const Twist& V_WL) noexcept {
  impl_->pipeline.setPointerTarget(i, X_WL, V_WL);
}
Wrench World::pointerWrench(int i) const noexcept {
  const double* F = impl_->pipeline.state().pointers[i].F_W;
  return {Vector3(F[0], F[1], F[2]), Vector3(F[3], F[4], F[5])};
}
void World::grab(int pointer, int link) { impl_->pipeline.grab(pointer, link); }
int World::pointerHome(int i) const { return impl_->pipeline.pointerHome(i); }
bool World::canGrab(int pointer, int link) const noexcept { return impl_->pipeline.canGrab(pointer, link); }
bool World::tryGrab(int pointer, int link) noexcept { return impl_->pipeline.tryGrab(pointer, link); }

const WorldTuning& World::tuning() const { return impl_->pipeline.tuning(); }
void World::tune(const WorldTuning& tuning) { impl_->pipeline.tune(tuning); }

int World::contactCount() const { return impl_->pipeline.contacts().size(); }
const ContactReport& World::contact(int i) const { return impl_->pipeline.contacts()[i]; }

const StepHistory& World::history() const { return impl_->pipeline.history(); }

std::uint64_t World::hash() const { return impl_->pipeline.state().hash(); }
std::vector<double> World::save() const { return impl_->pipeline.state().pack(); }
void World::restore(const std::vector<double>& state) { impl_->pipeline.restore(state); }
std::string World::planText() const { return impl_->pipeline.text(); }

}  // namespace haptic
