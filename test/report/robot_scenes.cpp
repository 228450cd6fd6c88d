// Links on joints: a chain, an arm with a load, a quadruped.
#include "../scenes/balls.h"
#include "exact_chain.h"
#include "report_scene.h"

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

/// Four legs of thigh and shank with ball feet. Front knees point backwards and rear ones forwards: what is in front is mirrored behind.
struct Quadruped {
  static constexpr double kBody = 10, kThigh = 0.8, kShank = 0.2;    // [kg]
  static constexpr double kLength = 0.25, kFoot = 0.03, kBend = 0.5;  // [m], [m], [rad] of the thighs
  static constexpr double kStiffness = 150, kDamping = 1;            // [N·m/rad], [N·m·s/rad]
  static constexpr double kLegX = 0.2, kLegY = 0.1;                  // [m] of the hips
  static double height() { return 2 * kLength * std::cos(kBend) + kFoot; }  // of the hips over the ground
  static double load() { return (kBody + 4 * (kThigh + kShank)) * kGravity / 4; }  // on each foot [N]

  /// Depth at which the foot's cap carries its load: k π d² (3 r − d)/3.
  static double depth(double k) {
    double d = 0;
    for (int i = 0; i < 100; ++i) d = std::sqrt(load() / (k * M_PI * (kFoot - d / 3)));
    return d;
  }

  static LinkDef segment(const std::string& name, int parent, const Vector3& p, double q, double mass, double effort) {
    LinkDef link = hinged(name, parent, Pose(p), q);
    link.inertia.mass = mass;
    link.inertia.p_LC = Vector3(0, 0, -kLength / 2);
    const double across = mass * kLength * kLength / 12;
    link.inertia.I_C = Vector3(across, across, 0.1 * across).asDiagonal();
    link.joint.drive = JointDef::Drive::kPosition;
    link.joint.drive_stiffness = kStiffness;
    link.joint.drive_damping = kDamping;
    link.joint.drive_effort = effort;
    return link;
  }

  static WorldDef make(const WorldSettings& settings, double k) {
    WorldDef def;
    def.name = "quadruped";
    def.settings = settings;
    def.settings.gravity = Vector3(0, 0, -kGravity);
    ContactMaterial& m = def.settings.default_material;
    m.stiffness = k;
    m.dissipation = 10;
    m.mu_static = m.mu_dynamic = 0.8;
    def.articulations.push_back(scenes::groundPlane());
    const Vector3 size(0.5, 0.2, 0.1);
    ArticulationDef robot = scenes::freeBox("quadruped", size, kBody, Pose(Vector3(0, 0, height() - depth(k))));
    for (const int x : {1, -1}) {
      for (const int y : {1, -1}) {
        // A turn by +q about y leads what hangs down to −x. The foot is under the hip, the knee beside both by `aside`.
        const double thigh = x * kBend, aside = -kLength * std::sin(thigh);
        const double at_knee = -aside * load() + aside / 2 * kShank * kGravity;
        const double at_hip = -aside / 2 * (kThigh + kShank) * kGravity;
        const std::string leg = std::string(x > 0 ? "front" : "rear") + (y > 0 ? "_left" : "_right");
        const int body = static_cast<int>(robot.links.size());
        robot.links.push_back(segment(leg + "_thigh", 0, Vector3(x * kLegX, y * kLegY, 0), thigh, kThigh, at_hip));
        robot.links.push_back(segment(leg + "_shank", body, Vector3(0, 0, -kLength), -2 * thigh, kShank, at_knee));
        CollisionDef foot;
        foot.name = leg + "_foot";
        foot.shape = std::make_shared<Ball>(kFoot);
        foot.X_LS = Pose(Vector3(0, 0, -kLength));
        robot.links.back().collisions.push_back(foot);
      }
    }
    def.articulations.push_back(robot);
    return def;
  }

  /// On rigid ground it stays: body, then thigh and shank of each leg.
  static std::vector<BodyState> standing() {
    std::vector<BodyState> states = {{Pose(Vector3(0, 0, height())), Twist{}}};
    for (const int x : {1, -1}) {
      for (const int y : {1, -1}) {
        const Matrix3 turn = Eigen::AngleAxisd(x * kBend, Vector3::UnitY()).toRotationMatrix();
        const Vector3 hip(x * kLegX, y * kLegY, height());
        states.push_back({Pose(turn, hip), Twist{}});
        states.push_back({Pose(Matrix3(turn.transpose()), Vector3(hip - kLength * turn.col(2))), Twist{}});
      }
    }
    return states;
  }
};

Scene quadrupedStands() {
  Scene s;
  s.name = "quadruped_stands";
  s.title = "Quadruped of nine links that stands on four ball feet";
  s.parameters =
      "body 10 kg, thighs 0.8 kg, shanks 0.2 kg, both 0.25 m, thighs at .5 rad, feet of 30 mm, mu 0.8; drives 150 N m/rad, 1 N m s/rad, "
      "feed-forward of the rigid statics; released touching, 1 s";
  s.reference = "rigid: it stays";
  s.seconds = 1;
  s.stiffness = 1e9;
  for (int i = 1; i <= 9; ++i) s.bodies.push_back(i);
  s.make = [](const Choice& choice) { return Quadruped::make(settingsOf(choice), choice.stiffness > 0 ? choice.stiffness : 1e9); };
  s.exact = [](double) { return Quadruped::standing(); };
  return s;
}

}  // namespace

std::vector<Scene> robotScenes() { return {swingingChain(), armWithLoad(), quadrupedStands()}; }

}  // namespace haptic::report
