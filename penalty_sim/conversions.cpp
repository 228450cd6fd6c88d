#include "penalty_sim/conversions.h"

#include "haptic_core/loop/realtime.h"

namespace haptic {
namespace {

geometry_msgs::Quaternion asQuaternion(const Matrix3& R) {
  const Quaternion q = Quaternion(R).normalized();
  geometry_msgs::Quaternion m;
  m.w = q.w();
  m.x = q.x();
  m.y = q.y();
  m.z = q.z();
  return m;
}

Quaternion quaternionFrom(const geometry_msgs::Quaternion& q) { return Quaternion(q.w, q.x, q.y, q.z).normalized(); }

std::string nameOf(int link, const std::vector<std::string>& links) {
  return link >= 0 && link < static_cast<int>(links.size()) ? links[link] : std::string();
}

}  // namespace

geometry_msgs::Point asPoint(const Vector3& p) {
  geometry_msgs::Point m;
  m.x = p.x();
  m.y = p.y();
  m.z = p.z();
  return m;
}

geometry_msgs::Vector3 asVector(const Vector3& v) {
  geometry_msgs::Vector3 m;
  m.x = v.x();
  m.y = v.y();
  m.z = v.z();
  return m;
}

geometry_msgs::Pose asPose(const Pose& X) {
  geometry_msgs::Pose m;
  m.position = asPoint(X.p);
  m.orientation = asQuaternion(X.R);
  return m;
}

geometry_msgs::Transform asTransform(const Pose& X) {
  geometry_msgs::Transform m;
  m.translation = asVector(X.p);
  m.rotation = asQuaternion(X.R);
  return m;
}

geometry_msgs::Wrench asWrench(const Wrench& F) {
  geometry_msgs::Wrench m;
  m.force = asVector(F.force);
  m.torque = asVector(F.torque);
  return m;
}

Pose poseFrom(const geometry_msgs::Pose& pose) {
  return {quaternionFrom(pose.orientation), Vector3(pose.position.x, pose.position.y, pose.position.z)};
}

Pose poseFrom(const geometry_msgs::Transform& transform) {
  const auto& p = transform.translation;
  return {quaternionFrom(transform.rotation), Vector3(p.x, p.y, p.z)};
}

bool finite(const Pose& X) { return X.p.allFinite() && X.R.allFinite(); }

ros::Time stampOf(std::int64_t steady_ns) {
  const ros::Time now = ros::Time::now();
  if (ros::Time::isSimTime()) return now;
  return now - ros::Duration().fromNSec(steadyNow() - steady_ns);
}

haptic_msgs::EnergyLedger asLedger(const EnergyLedger& energy) {
  haptic_msgs::EnergyLedger m;
  m.kinetic = energy.kinetic;
  m.potential = energy.potential;
  m.elastic = energy.elastic;
  m.damping = energy.damping;
  m.friction = energy.friction;
  m.external = energy.external;
  return m;
}

haptic_msgs::Contacts asContacts(const WorldSnapshot& snapshot, const std::vector<std::string>& links) {
  haptic_msgs::Contacts m;
  m.step = snapshot.report.step;
  m.time = snapshot.time;
  for (int i = 0; i < snapshot.contacts; ++i) {
    const ContactReport& c = snapshot.contact[i];
    if (!finite(c.X_WP) || !c.F_BP_W.allFinite()) continue;
    haptic_msgs::Contact contact;
    contact.link_a = nameOf(c.link_a, links);
    contact.link_b = nameOf(c.link_b, links);
    contact.patch = asPose(c.X_WP);
    contact.wrench = asWrench(c.F_BP_W);
    contact.normal_force = c.normal_force;
    contact.volume = c.volume;
    contact.area = c.area;
    contact.depth = c.depth;
    contact.sticking = c.sticking;
    m.contacts.push_back(contact);
  }
  return m;
}

haptic_msgs::StepReport asStepReport(const WorldSnapshot& snapshot, const std::vector<std::string>& links, double step) {
  const StepReport& r = snapshot.report;
  haptic_msgs::StepReport m;
  m.step = r.step;
  m.time = snapshot.time;
  m.step_size = step;
  m.pairs = static_cast<std::uint32_t>(r.pairs);
  m.contacts = static_cast<std::uint32_t>(r.contacts);
  m.iterations = static_cast<std::uint32_t>(r.iterations);
  m.residual = r.residual;
  m.finite = r.finite;
  m.culprit = nameOf(r.culprit, links);
  m.flags = r.flags;
  m.energy = asLedger(r.energy);
  return m;
}

}  // namespace haptic
