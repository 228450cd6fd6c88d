// Links on joints: a chain, an arm with a load, a quadruped, a hand.
#include "exact_chain.h"
#include "hand_grasp.h"
#include "quadruped.h"

namespace haptic::report {
namespace {

constexpr double kGravity = 9.8;  // [m/s²]

LinkDef hinged(const std::string& name, int parent, const Pose& X_PJ, double q) {
  LinkDef link;
  link.name = name;
  link.parent = parent;
  link.joint.name = name + "_joint";
  link.joint.type = JointType::kRevolute;
  link.joint.axis = Vector3::UnitY();
  link.joint.X_PJ = X_PJ;
  link.joint.position = q;
  return link;
}

/// A row of links with round inertia across, hinged to the world.
WorldDef rowOf(const std::string& name, const std::vector<PlanarLink>& links, const WorldSettings& settings) {
  WorldDef def;
  def.name = name;
  def.settings = settings;
  def.settings.gravity = Vector3(0, 0, -kGravity);
  ArticulationDef tree;
  tree.name = name;
  JointPathDef wanted{"targets", {}, {0}, {}};
  for (int i = 0; i < static_cast<int>(links.size()); ++i) {
    const PlanarLink& l = links[i];
    LinkDef link = hinged("link" + std::to_string(i), i - 1, Pose(Vector3(i == 0 ? 0 : links[i - 1].length, 0, 0)), l.start);
    link.inertia.mass = l.mass;
    link.inertia.p_LC = Vector3(l.centre, 0, 0);
    link.inertia.I_C = Vector3(0.5 * l.inertia, l.inertia, l.inertia).asDiagonal();
    if (l.stiffness > 0) {
      link.joint.drive = JointDef::Drive::kPosition;
      link.joint.drive_stiffness = l.stiffness;
      link.joint.drive_damping = l.damping;
      wanted.joints.emplace_back(0, i);
      wanted.position.push_back(l.target);
    }
    tree.links.push_back(link);
  }
  def.articulations.push_back(tree);
  if (!wanted.joints.empty()) def.joint_paths.push_back(wanted);
  return def;
}

std::vector<BodyState> statesOf(const std::vector<PlanarLink>& links, const PlanarChain::Motion& m) {
  std::vector<BodyState> states;
  BodyState s;
  for (std::size_t i = 0; i < links.size(); ++i) {
    const double angle = static_cast<double>(m.angle[i]);
    s.X_WL.R = Eigen::AngleAxisd(angle, Vector3::UnitY()).toRotationMatrix();
    s.V_WL.angular = static_cast<double>(m.rate[i]) * Vector3::UnitY();
    states.push_back(s);
    const Vector3 along = links[i].length * s.X_WL.R.col(0);
    s.V_WL.linear += s.V_WL.angular.cross(along);
    s.X_WL.p += along;
  }
  return states;
}

Scene row(const std::string& name, const std::vector<PlanarLink>& links) {
  Scene s;
  s.name = name;
  s.reference = "Lagrange's equations in absolute angles, Runge-Kutta in long double";
  s.seconds = 1;
  s.stiffer_is_truer = false;  // nothing touches
  for (int i = 0; i < static_cast<int>(links.size()); ++i) s.bodies.push_back(i);
  s.make = [name, links](const Choice& choice) { return rowOf(name, links, settingsOf(choice)); };
  const auto chain = std::make_shared<PlanarChain>(links, kGravity);
  s.exact = [links, chain](double t) { return statesOf(links, chain->at(t)); };
  return s;
}

PlanarLink rod(double length, double mass) {
  PlanarLink l;
  l.length = length;
  l.mass = mass;
  l.centre = length / 2;
  l.inertia = mass * length * length / 12;
  return l;
}

Scene swingingChain() {
  Scene s = row("swinging_chain", std::vector<PlanarLink>(5, rod(0.1, 0.1)));
  s.title = "Chain of five links that swings without damping";
  s.parameters = "rods of 0.1 m, 0.1 kg on hinges about y, released from the horizontal, 1 s";
  return s;
}

Scene armWithLoad() {
  std::vector<PlanarLink> links = {rod(0.4, 3), rod(0.4, 2), rod(0.1, 0.5)};
  PlanarLink& hand = links.back();  // with the load, a ball of 2 kg and 40 mm around its end
  const double load = 2, mass = hand.mass + load, centre = (hand.mass * hand.centre + load * hand.length) / mass;
  hand.inertia += hand.mass * std::pow(hand.centre - centre, 2) + load * (0.4 * 0.04 * 0.04 + std::pow(hand.length - centre, 2));
  hand.mass = mass;
  hand.centre = centre;
  const double stiffness[] = {600, 300, 50}, damping[] = {30, 15, 1}, from[] = {0.3, -1, 0.5}, to[] = {-0.9, 1.2, -0.3};
  for (int i = 0; i < 3; ++i) {
    links[i].stiffness = stiffness[i];
    links[i].damping = damping[i];
    links[i].start = from[i];
    links[i].target = to[i];
  }
  Scene s = row("arm_load", links);
  s.title = "Arm that swings a load into another posture";
  s.parameters =
      "rods of 0.4, 0.4, 0.1 m and 3, 2, 0.5 kg on hinges about y, a ball of 2 kg at the end; drives 600, 300, 50 N m/rad and 30, 15, 1 N "
      "m s/rad towards -.9, 1.2, -.3 rad from .3, -1, .5 rad, 1 s";
  return s;
}

constexpr const char* kQuadruped =
    "body 10 kg, thighs 0.8 kg, shanks 0.2 kg, both 0.25 m, feet of 30 mm, mu 0.8; drives 150 N m/rad, 1 N m s/rad; ";

double ownStiffness(const Choice& choice, double own) { return choice.stiffness > 0 ? choice.stiffness : own; }

Scene quadrupedStands() {
  Scene s;
  s.name = "quadruped_stands";
  s.title = "Quadruped of nine links that stands on four ball feet";
  s.parameters = kQuadruped + std::string("thighs at .5 rad, feed-forward of the rigid statics, released touching, 1 s");
  s.reference = "rigid: it stays";
  s.seconds = 1;
  s.stiffness = 1e9;
  for (int i = 1; i <= 9; ++i) s.bodies.push_back(i);
  s.make = [](const Choice& choice) { return Quadruped::stands(settingsOf(choice), ownStiffness(choice, 1e9)); };
  s.exact = [](double) { return Quadruped::standing(); };
  return s;
}

Scene quadrupedWalks() {
  Scene s = quadrupedStands();
  s.name = "quadruped_walks";
  s.title = "Quadruped that walks a step of 0.12 m";
  s.parameters = kQuadruped + std::string(
      "its drives follow a path: hind left, fore left, body, hind right, fore right, body; a leg in 0.4 s, lifted by 30 mm, the body "
      "in 0.5 s; feed-forward of the rigid inverse dynamics, 3.1 s");
  s.reference = "rigid: the path's own motion, for its inverse dynamics is fed forward to the drives";
  s.seconds = QuadrupedWalk::kEnd;
  s.samples = 62;
  s.make = [](const Choice& choice) { return QuadrupedWalk::make(settingsOf(choice), ownStiffness(choice, 1e9)); };
  s.exact = QuadrupedWalk::at;
  return s;
}

Scene handGrasp() {
  Scene s;
  s.name = "hand_grasp";
  s.title = "Hand of four fingers that holds a bar";
  s.parameters =
      "17 links on 16 hinges, lengths and masses as of an Allegro hand, tips of 12 mm; bar 50 x 140 x 50 mm, 0.2 kg, between three "
      "fingers and the thumb, 4 N, mu 0.8; drives 1 N m/rad, 5 mN m s/rad, feed-forward of the rigid statics; released touching, 2 s";
  s.reference = "rigid: it stays, carried by friction";
  s.seconds = 2;
  s.stiffness = 1e9;
  s.size = HandGrasp::kTip;
  for (int i = 0; i < HandGrasp::kLinks; ++i) s.bodies.push_back(i);
  s.make = [](const Choice& choice) { return HandGrasp::make(settingsOf(choice), ownStiffness(choice, 1e9)); };
  s.exact = [](double) { return HandGrasp::states(); };
  return s;
}

}  // namespace

std::vector<Scene> robotScenes() { return {swingingChain(), armWithLoad(), quadrupedStands(), quadrupedWalks(), handGrasp()}; }

}  // namespace haptic::report
