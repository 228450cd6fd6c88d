#include "penalty_sim/conversions.h"

namespace haptic {
namespace {

std::string nameOf(int link, const std::vector<std::string>& links) {
  return link >= 0 && link < static_cast<int>(links.size()) ? links[link] : std::string();
}

}  // namespace

haptic_msgs::Contacts toContacts(const WorldSnapshot& snapshot, const std::vector<std::string>& links, PatchOutline& outline) {
  haptic_msgs::Contacts m;
  m.step = snapshot.report.step;
  m.time = snapshot.time;
  for (int i = 0; i < snapshot.contacts; ++i) {
    const ContactReport& c = snapshot.contact[i];
    if (!finite(c.X_WP) || !c.F_BP_W.allFinite()) continue;
    haptic_msgs::Contact contact;
    contact.link_a = nameOf(c.link_a, links);
    contact.link_b = nameOf(c.link_b, links);
    contact.patch = toPose(c.X_WP);
    contact.wrench = toWrench(c.F_BP_W);
    contact.normal_force = c.normal_force;
    contact.volume = c.volume;
    contact.area = c.area;
    contact.depth = c.depth;
    contact.sticking = c.sticking;
    contact.centre_of_pressure = toPoint(centreOfPressure(c));
    contact.slip_velocity = toVector(snapshot.slip[i]);
    const std::vector<Vector3>& corners = outline.of(c, snapshot.pose[c.link_a], snapshot.pose[c.link_b]);
    for (const Vector3& corner : corners) contact.polygon.push_back(toPoint(corner));
    m.contacts.push_back(contact);
  }
  return m;
}

haptic_msgs::StepReport toStepReport(const WorldSnapshot& snapshot, const std::vector<std::string>& links, double step) {
  const StepReport& r = snapshot.report;
  haptic_msgs::StepReport m;
  m.step = r.step;
  m.time = snapshot.time;
  m.step_size = step;
  m.pairs = static_cast<std::uint32_t>(r.pairs);
  m.contacts = static_cast<std::uint32_t>(r.contacts);
  m.standing = static_cast<std::uint32_t>(r.standing);
  m.waiting = static_cast<std::uint32_t>(r.waiting);
  m.lag = r.lag;
  m.work = r.work;
  m.iterations = static_cast<std::uint32_t>(r.iterations);
  m.residual = r.residual;
  m.position_error = r.position_error;
  m.finite = r.finite;
  m.culprit = nameOf(r.culprit, links);
  m.flags = r.flags;
  m.energy = toLedger(r.energy);
  return m;
}

haptic_msgs::LiveReport toLiveReport(const WorldCopy& copy, const ErrorEstimate& estimate,
                                     const std::vector<std::string>& links, const WorldSettings& settings) {
  haptic_msgs::LiveReport m;
  m.step = copy.report.step;
  m.time = copy.time;
  m.step_size = settings.step;
  m.window_steps = static_cast<std::uint32_t>(estimate.steps);
  m.order = static_cast<std::uint32_t>(estimate.order);
  m.position_error = estimate.position;
  m.position_error_link = nameOf(estimate.link, links);
  m.rotation_error = estimate.rotation;
  m.energy_error = estimate.energy;
  m.force_error = estimate.force;
  m.torque_error = estimate.torque;
  m.energy = toLedger(copy.report.energy);
  m.energy_balance = copy.report.energy.balance();
  m.stage_search = copy.stages.search;
  m.stage_detection = copy.stages.detection;
  m.stage_volume = copy.stages.volume;
  m.stage_force = copy.stages.force;
  m.stage_motion = copy.stages.motion;
  return m;
}

}  // namespace haptic
