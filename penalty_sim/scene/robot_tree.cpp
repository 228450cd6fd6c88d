#include "scene/robot_tree.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>
#include <utility>

#include "haptic_core/geometry/shapes/half_space.h"
#include "scene/contact_properties.h"
#include "scene/joint_reading.h"
#include "scene/link_inertia.h"
#include "scene/link_visuals.h"
#include "scene/motion_reading.h"
#include "scene/number_bounds.h"
#include "scene/scene_extension.h"

namespace haptic {
namespace {

class TreeBuilder {
 public:
  TreeBuilder(const RobotFile& robot, const ModelSettings& settings, const SceneOptions& options,
              LoadContext& context)
      : robot_(robot),
        settings_(settings),
        options_(options),
        context_(context),
        contact_(robot),
        colours_(robot, context.scene) {}

  void build();

 private:
  /// A URDF link to be placed: at X_LM in link `link`, or as a new link when `joint` moves.
  struct Visit {
    int xml_link, joint;
    int parent;  ///< link of the articulation that is being built
    Pose X_PM;   ///< of the joint frame in it
  };
  struct Root {
    int xml_link, joint;  ///< joint -1: the model's own root
    Pose X_WA;
  };

  bool isWorld(int xml_link) const;
  bool isPublishedRobot() const;
  void startArticulation(const Root& root);
  void grow(int xml_link, int articulation, int link);
  int addLink(int articulation, int parent, int xml_link, const JointDef& joint);
  int addMoving(int articulation, int parent, int xml_link, const JointXml& xml, JointDef joint);
  void place(int xml_link, int articulation, int link, const Pose& X_LM);
  void addCollisions(const LinkXml& link, CollisionReport& report, const Pose& X_LM, int articulation, int target);
  void refuseMotion(const std::string& where, const std::string& name, const std::string& shape, int articulation, int link) const;
  void addPicture(const LinkXml& link, const ShapePieces& shape, const CollisionDef& collision, int articulation, int target_link);
  void finish(int articulation);
  void shareInertia(int articulation);
  void resolveMimics(ArticulationDef& articulation);
  const ArticulationDef& current(int articulation) const {
    return context_.scene.world.articulations[articulation];
  }

  const RobotFile& robot_;
  const ModelSettings& settings_;
  const SceneOptions& options_;
  LoadContext& context_;
  ContactProperties contact_;
  MaterialColours colours_;
  std::vector<Root> pending_;              ///< subtrees that start articulations of their own
  std::vector<bool> has_inertial_;         ///< per link of the articulation that is being built
  std::map<std::string, int> joint_link_;  ///< URDF joint -> link of the articulation that is being built
};

/// A link named world stands for W; so does an empty root from which something floats.
bool TreeBuilder::isWorld(int xml_link) const {
  const LinkXml& link = robot_.links[xml_link];
  if (link.name == "world") return true;
  if (link.element->FirstChildElement("inertial") || !link.collisions.empty()) return false;
  return std::any_of(link.child_joints.begin(), link.child_joints.end(), [&](int j) {
    return kindOf(robot_.joints[j])->floating;
  });
}

bool TreeBuilder::isPublishedRobot() const {
  if (hasExtension(*robot_.xml.root(), "haptic:sensor")) return false;  // a robot with sensors is as it was without
  const auto& joints = robot_.links[robot_.root].child_joints;
  return !isWorld(robot_.root) ||
         std::all_of(joints.begin(), joints.end(), [&](int j) { return robot_.joints[j].type == "fixed"; });
}

void TreeBuilder::build() {
  context_.scene.joints += static_cast<int>(robot_.joints.size());
  for (const std::string& warning : robot_.warnings) context_.scene.warnings.push_back(warning);
  for (const std::string& note : robot_.notes) context_.scene.notes.push_back(note);
  for (const std::string& line : robot_.replaced) context_.scene.replaced.push_back(line);
  context_.scene.collisions_tried += robot_.collisions_left_out;
  for (const JointXml& joint : robot_.joints) {
    if (joint.says_effort) context_.effort_places[settings_.prefix + joint.name] = robot_.at(joint);
  }
  const LinkXml& root = robot_.links[robot_.root];
  if (isWorld(robot_.root)) {
    if (settings_.floating) {
      throw SetupError(robot_.at(root), "the base is to float, but the file fixes its bodies to the world",
                       "take \"base: floating\" out");
    }
    context_.frames[settings_.prefix + root.name] = {-1, -1, settings_.X_WM};
    if (!root.collisions.empty() || root.element->FirstChildElement("visual")) {
      pending_.push_back({robot_.root, -1, settings_.X_WM});
    }
    for (int j : root.child_joints) {
      pending_.push_back(
          {robot_.joints[j].child, j, settings_.X_WM * readOrigin(robot_.xml, *robot_.joints[j].element)});
    }
  } else {
    pending_.push_back({robot_.root, -1, settings_.X_WM});
  }
  for (std::size_t i = 0; i < pending_.size(); ++i) startArticulation(Root(pending_[i]));
}

void TreeBuilder::startArticulation(const Root& root) {
  const int index = static_cast<int>(context_.scene.world.articulations.size());
  context_.scene.world.articulations.emplace_back();
  context_.places.emplace_back();
  has_inertial_.clear();
  joint_link_.clear();
  ArticulationDef& articulation = context_.scene.world.articulations.back();
  const bool model_root = root.joint < 0;
  articulation.name =
      settings_.prefix +
      (model_root && !isWorld(root.xml_link) ? robot_.name : robot_.links[root.xml_link].name);
  articulation.X_WA = root.X_WA;
  JointDef joint;
  if (model_root) {
    joint.name = articulation.name + "_base";
    joint.type = (settings_.floating || settings_.floats_unless_world) && !isWorld(robot_.root) ? JointType::kFloating : JointType::kFixed;
  } else {
    joint = readJoint(robot_, robot_.joints[root.joint], settings_, context_.scene.warnings);
    joint.X_PJ = Pose();  // its origin is in X_WA already
    articulation.V_WA = readInitialTwist(robot_, robot_.joints[root.joint]);
  }
  const int link = model_root ? addLink(index, -1, root.xml_link, joint)
                              : addMoving(index, -1, root.xml_link, robot_.joints[root.joint], joint);
  if (!model_root) joint_link_[robot_.joints[root.joint].name] = link;
  grow(root.xml_link, index, link);
  finish(index);
}

int TreeBuilder::addLink(int articulation, int parent, int xml_link, const JointDef& joint) {
  LinkDef link;
  link.name = settings_.prefix + robot_.links[xml_link].name;
  // The link that carries the world's own shapes must not share the name of the frame W.
  if (link.name == "world") link.name = "world_fixed";
  link.parent = parent;
  link.joint = joint;
  has_inertial_.push_back(false);
  context_.places[articulation].push_back(robot_.at(robot_.links[xml_link]));
  auto& links = context_.scene.world.articulations[articulation].links;
  links.push_back(link);
  return static_cast<int>(links.size()) - 1;
}

/// The link of a joint. Of a screw it turns on a link without mass, which slides by the lead.
int TreeBuilder::addMoving(int articulation, int parent, int xml_link, const JointXml& xml, JointDef joint) {
  const double lead = readLead(robot_, xml);
  if (lead == 0) return addLink(articulation, parent, xml_link, joint);
  JointDef slide;
  slide.name = joint.name + "_slide";
  slide.type = JointType::kPrismatic;
  slide.X_PJ = std::exchange(joint.X_PJ, Pose());
  slide.axis = joint.axis;
  slide.mimic_multiplier = lead / (2 * M_PI);
  for (double JointDef::*number : {&JointDef::thread_friction, &JointDef::thread_radius, &JointDef::thread_flank})
    std::swap(slide.*number, joint.*number);
  const int between = addLink(articulation, parent, xml_link, slide);
  LinkDef& link = context_.scene.world.articulations[articulation].links[between];
  link.name += "_slide";
  link.joint.mimic_joint = between + 1;
  has_inertial_[between] = true;  // it has none
  return addLink(articulation, between, xml_link, joint);
}

/// Depth first, in the order of the file: parents come before their children.
void TreeBuilder::grow(int xml_link, int articulation, int root) {
  std::vector<Visit> open = {{xml_link, -1, root, Pose()}};
  std::vector<std::pair<int, std::size_t>> floating;  ///< link they hang on, index in pending_
  while (!open.empty()) {
    const Visit visit = open.back();
    open.pop_back();
    int link = visit.parent;
    Pose X_LM = visit.X_PM;
    if (visit.joint >= 0 && robot_.joints[visit.joint].type != "fixed") {
      JointDef joint = readJoint(robot_, robot_.joints[visit.joint], settings_, context_.scene.warnings);
      joint.X_PJ = visit.X_PM;
      link = addMoving(articulation, visit.parent, visit.xml_link, robot_.joints[visit.joint], joint);
      context_.parts[settings_.prefix + robot_.links[robot_.joints[visit.joint].parent].name].children.push_back(link);
      joint_link_[robot_.joints[visit.joint].name] = link;
      X_LM = Pose();
    } else if (visit.joint >= 0) {
      context_.scene.world.articulations[articulation].links[link].merged.push_back(
          {settings_.prefix + robot_.links[visit.xml_link].name, X_LM});
    }
    place(visit.xml_link, articulation, link, X_LM);
    if (visit.xml_link == robot_.root && isWorld(robot_.root))
      continue;  // its children are articulations of their own
    const std::vector<int>& joints = robot_.links[visit.xml_link].child_joints;
    for (auto j = joints.rbegin(); j != joints.rend(); ++j) {
      const JointXml& joint = robot_.joints[*j];
      const Pose X_LJ = X_LM * readOrigin(robot_.xml, *joint.element);
      if (kindOf(joint)->floating) {
        // A free body wherever it hangs in the file; its initial pose follows from the finished tree.
        floating.emplace_back(link, pending_.size());
        pending_.push_back({joint.child, *j, X_LJ});
      } else {
        open.push_back({joint.child, *j, link, X_LJ});
      }
    }
  }
  if (floating.empty()) return;
  const std::vector<Pose> X_WL = initialPoses(current(articulation));
  for (const auto& [link, pending] : floating) pending_[pending].X_WA = X_WL[link] * pending_[pending].X_WA;
}

/// Attaches a URDF link's inertia, shapes and visuals to `link`, in which it lies at X_LM.
void TreeBuilder::place(int xml_link, int articulation, int link, const Pose& X_LM) {
  const LinkXml& xml = robot_.links[xml_link];
  const std::string name = settings_.prefix + xml.name;
  const bool named =
      isWorld(xml_link) || context_.frames.emplace(name, FramePlace{articulation, link, X_LM}).second;
  if (!named) {
    throw SetupError(robot_.at(xml), "another model of the scene has a link '" + name + "'",
                     "give the models prefixes");
  }
  LinkDef& target = context_.scene.world.articulations[articulation].links[link];
  LinkPart& part = context_.parts[name];
  CollisionReport report;
  const auto first = static_cast<std::ptrdiff_t>(target.collisions.size());
  addCollisions(xml, report, X_LM, articulation, link);
  JudgedLink judged{robot_.at(xml), articulation, link, {target.collisions.begin() + first, target.collisions.end()}, {}, {X_LM.p}};
  for (std::size_t c = 0; c < judged.collisions.size(); ++c) part.collisions.push_back(static_cast<int>(c) + static_cast<int>(first));
  if (xml.element->FirstChildElement("inertial")) {
    LinkInertia inertia = readInertia(robot_, xml);
    if (xml.spread_inertia) inertia.I_C = X_LM.R.transpose() * momentsOfShapes(judged.collisions, inertia.mass) * X_LM.R;
    merge(inertia, X_LM, target.inertia);
    merge(inertia, X_LM, part.inertia);
    has_inertial_[link] = true;
    judged.inertia = part.inertia;
  }
  for (const int child : xml.child_joints) judged.joints.push_back(X_LM * readOrigin(robot_.xml, *robot_.joints[child].element).p);
  context_.judged.push_back(judged);
  for (VisualDef visual : readVisuals(robot_, xml, colours_, context_.missing_pictures, context_.scene)) {
    visual.articulation = articulation;
    visual.link = link;
    visual.name = name;
    visual.X_LV = X_LM * visual.X_LV;
    context_.scene.visuals.push_back(visual);
  }
}

/// Throws where a shape that cannot move would.
void TreeBuilder::refuseMotion(const std::string& where, const std::string& name, const std::string& shape, int articulation,
                               int link) const {
  const std::vector<LinkDef>& links = context_.scene.world.articulations[articulation].links;
  for (; link >= 0; link = links[link].parent) {
    if (links[link].joint.type == JointType::kFixed) continue;
    throw SetupError(where + ": link '" + name + "'", "it moves and has " + shape,
                     "put that on a link that is fixed to the world, or give the link a box");
  }
}

void TreeBuilder::addCollisions(const LinkXml& link, CollisionReport& report, const Pose& X_LM, int articulation,
                                int target_link) {
  LinkDef& target = context_.scene.world.articulations[articulation].links[target_link];
  report.link = settings_.prefix + link.name;
  for (std::size_t c = 0; c < link.collisions.size(); ++c) {
    ++context_.scene.collisions_tried;
    const XmlElement& element = *link.collisions[c];
    refuseUnknownExtensions(robot_.xml, element, {"haptic:contact", "haptic:shape", "haptic:belt"});
    const ShapePieces shape = context_.shapes.make(robot_, link, element);
    const std::string where = robot_.xml.at(element) + ": link '" + link.name + "'";
    if (!shape.replaced.empty()) context_.scene.replaced.push_back(where + ": " + shape.replaced);
    if (!shape.to_mend.empty()) context_.scene.warnings.push_back(where + ": " + shape.to_mend);
    if (shape.pieces.empty()) continue;
    if (!shape.fixed_only.empty()) refuseMotion(robot_.xml.at(element), link.name, shape.fixed_only, articulation, target_link);
    CollisionDef collision;
    collision.material =
        contact_.of(link, element, shape.half_extent, collision.material_source, context_.scene.notes);
    if (options_.rigid) {
      collision.material.stiffness = ContactMaterial::kRigid;
      collision.material.tangential_stiffness = ContactMaterial::kUnset;  // of the stiffness that the file gave
    }
    collision.X_LS = X_LM * readOrigin(robot_.xml, element);
    collision.belt = readBelt(robot_.xml, element, X_LM);
    const char* given = element.Attribute("name");
    if (!collision.material.saysNumber()) {
      context_.silent.push_back({articulation, target_link, target.collisions.size(), shape.pieces.size(),
                                 context_.scene.collisions.size(), 2 * shape.half_extent});
    }
    const std::string name = report.link + "/" + (given && *given ? given : "collision" + std::to_string(c));
    for (std::size_t p = 0; p < shape.pieces.size(); ++p) {
      collision.name = name + (shape.pieces.size() > 1 ? "/" + std::to_string(p) : "");
      collision.shape = shape.pieces[p];
      target.collisions.push_back(collision);
    }
    addPicture(link, shape, collision, articulation, target_link);
    ++context_.scene.collisions_loaded;
    report.text = shape.text;
    report.material = collision.material;
    report.material_source = collision.material_source;
    context_.scene.collisions.push_back(report);
  }
}

/// Ground is drawn as it collides, unless the file says otherwise; what stands in for a part of the file always is.
void TreeBuilder::addPicture(const LinkXml& link, const ShapePieces& shape, const CollisionDef& collision, int articulation,
                             int target_link) {
  std::vector<TriangleMesh> drawn;
  if (!shape.replaced.empty()) {
    for (const auto& piece : shape.pieces) drawn.push_back(piece->triangles());
  } else if (!shape.picture.triangles.empty() && !link.element->FirstChildElement("visual")) {
    drawn.push_back(shape.picture);
  }
  for (const TriangleMesh& mesh : drawn) {
    VisualDef visual;
    visual.articulation = articulation;
    visual.link = target_link;
    visual.name = settings_.prefix + link.name;
    visual.shape = VisualShape::kTriangles;
    visual.X_LV = collision.X_LS;
    visual.colour = {0.55f, 0.6f, 0.5f, 1.0f};
    if (!shape.replaced.empty()) visual.colour = kReplacedColour;
    for (const auto& triangle : mesh.triangles) {
      for (const int corner : triangle) visual.corners.push_back(mesh.vertices[corner]);
    }
    context_.scene.visuals.push_back(visual);
  }
}

void TreeBuilder::finish(int index) {
  ArticulationDef& articulation = context_.scene.world.articulations[index];
  resolveMimics(articulation);
  // A file whose masses cannot be right is none without masses.
  const double density = robot_.inertials_left_out > 0 && !(options_.default_density > 0) ? kEstimateDensity : options_.default_density;
  completeInertias(articulation, context_.places[index], has_inertial_, density, options_.words, context_.scene);
  shareInertia(index);
  for (int i = 0; i < static_cast<int>(articulation.links.size()); ++i) {
    int parent = articulation.links[i].parent;
    if (parent >= 0 && articulation.links[parent].joint.mimic_joint == i) parent = articulation.links[parent].parent;  // a nut's slide
    if (parent >= 0) context_.scene.world.filters.push_back({index, parent, index, i});
  }
  const bool hold = settings_.drive == ModelSettings::Drive::kHold ||
                    (settings_.drive == ModelSettings::Drive::kAsFile && isPublishedRobot());
  giveGains(articulation);
  if (hold) context_.held.push_back(index);
}

/// A joint goes no farther than the joints that follow it may. Limits that would leave it no way are not a follower's: exporters write 0
/// for limits not set.
void limitByFollower(const JointDef& follower, JointDef& followed, LoadReport& said) {
  const double m = follower.mimic_multiplier, c = follower.mimic_offset;
  if (m == 0 || !(follower.lower < follower.upper)) return;
  double lower = (follower.lower - c) / m, upper = (follower.upper - c) / m;
  if (m < 0) std::swap(lower, upper);
  constexpr double kDigits = 1e-3;  // of a range: limits of both are often one number in few digits [1]
  const double slack = kDigits * std::min(upper - lower, followed.upper - followed.lower);
  if (std::isfinite(slack) && lower <= followed.lower + slack && upper >= followed.upper - slack) return;
  if (lower <= followed.lower && upper >= followed.upper) return;
  std::ostringstream text;
  text << "joint '" << follower.name << "' follows '" << followed.name << "'";
  if (!(std::max(lower, followed.lower) < std::min(upper, followed.upper))) {
    text << ": no position is within the limits of both: its own are ignored";
    said.warnings.push_back(text.str());
    return;
  }
  followed.lower = std::max(lower, followed.lower), followed.upper = std::min(upper, followed.upper);
  text << " and limits it to " << followed.lower << "…" << followed.upper;
  const double position = std::clamp(followed.position, followed.lower, followed.upper);
  if (position != followed.position) text << "; it starts at " << position;
  followed.position = position;
  said.notes.push_back(text.str());
}

/// Parts of a link that got its mass from its shapes have theirs from them as well.
void TreeBuilder::shareInertia(int articulation) {
  const std::vector<LinkDef>& links = current(articulation).links;
  std::vector<double> given(links.size(), 0.0);
  std::vector<std::pair<int, LinkPart*>> parts;
  for (const auto& [name, place] : context_.frames) {
    const auto part = context_.parts.find(name);
    if (place.articulation != articulation || part == context_.parts.end()) continue;
    given[place.link] += part->second.inertia.mass;
    parts.emplace_back(place.link, &part->second);
  }
  constexpr double kRounding = 1e-9;  // of sums of masses [1]
  for (const auto& [link, part] : parts) {
    const LinkDef& whole = links[link];
    if (std::abs(given[link] - whole.inertia.mass) <= kRounding * whole.inertia.mass) continue;
    const double mass = inertiaOfShapes(whole.collisions, 1).mass;
    if (!(mass > 0)) continue;
    std::vector<CollisionDef> own;
    for (const int c : part->collisions) own.push_back(whole.collisions[c]);
    part->inertia = inertiaOfShapes(own, whole.inertia.mass / mass);
  }
}

void TreeBuilder::resolveMimics(ArticulationDef& articulation) {
  for (const JointXml& xml : robot_.joints) {
    const XmlElement* mimic = xml.element->FirstChildElement("mimic");
    const auto self = joint_link_.find(xml.name);
    if (!mimic || self == joint_link_.end()) continue;
    JointDef& joint = articulation.links[self->second].joint;
    const std::string master = mimic->Attribute("joint");
    const auto followed = joint_link_.find(master);
    const bool moves = followed != joint_link_.end();
    if (!moves || !isScalar(joint.type) || !isScalar(articulation.links[followed->second].joint.type)) {
      context_.scene.replaced.push_back(
          robot_.at(xml) + ": mimics joint '" + master +
          (moves ? "': only revolute, continuous and prismatic joints can" : "', which does not move or belongs to another body") +
          ": <mimic> is left out, and the joint moves by itself");
      continue;
    }
    joint.mimic_joint = followed->second;
    joint.mimic_multiplier = readNumber(robot_.xml, *mimic, "multiplier").value_or(1);
    joint.mimic_offset = readNumber(robot_.xml, *mimic, "offset").value_or(0);
  }
  // A follower of a follower follows the first one; checkMimic has excluded rings.
  for (LinkDef& link : articulation.links) {
    JointDef& joint = link.joint;
    while (joint.mimic_joint >= 0 && articulation.links[joint.mimic_joint].joint.mimic_joint >= 0) {
      const JointDef& master = articulation.links[joint.mimic_joint].joint;
      joint.mimic_offset += joint.mimic_multiplier * master.mimic_offset;
      joint.mimic_multiplier *= master.mimic_multiplier;
      joint.thread_radius *= std::abs(master.mimic_multiplier);  // the same lead angle for the first one's turn
      joint.mimic_joint = master.mimic_joint;
    }
    if (joint.mimic_joint < 0 || (std::abs(joint.mimic_multiplier) <= kMultiplierBounds.largest
        && std::isfinite(joint.mimic_offset))) continue;
    std::ostringstream text;
    text << "joint '" << joint.name << "' follows '" << articulation.links[joint.mimic_joint].joint.name
        << "' over others, with a multiplier of "
         << joint.mimic_multiplier << ": it cannot, and moves by itself";
    context_.scene.replaced.push_back(text.str());
    joint.mimic_joint = -1;
  }
  for (const LinkDef& link : articulation.links) {
    if (link.joint.mimic_joint >= 0) limitByFollower(link.joint, articulation.links[link.joint.mimic_joint].joint, context_.scene);
  }
  for (LinkDef& link : articulation.links) {
    JointDef& joint = link.joint;
    if (joint.mimic_joint < 0) continue;
    joint.position =
        joint.mimic_multiplier * articulation.links[joint.mimic_joint].joint.position + joint.mimic_offset;
  }
  for (std::size_t i = 0; i < articulation.links.size(); ++i)
    checkThread(context_.places[&articulation - context_.scene.world.articulations.data()][i], articulation, articulation.links[i].joint,
                context_.scene.notes);
}

}  // namespace

void addRobot(const RobotFile& robot, const ModelSettings& settings, const SceneOptions& options,
              LoadContext& context) {
  for (const auto& [name, position] : settings.joints) {
    if (robot.jointIndex(name) < 0) {
      throw SetupError(robot.xml.path(), "the scene sets joint '" + name + "', which does not exist",
                       "mend the name");
    }
  }
  TreeBuilder(robot, settings, options, context).build();
}

std::vector<Pose> initialPoses(const ArticulationDef& articulation) {
  std::vector<Pose> X_WL;
  for (const LinkDef& link : articulation.links) {
    const JointDef& joint = link.joint;
    Pose X_JL;
    if (isScalar(joint.type)) X_JL = scalarPose(kindOf(joint.type), joint.axis, joint.position);
    X_WL.push_back((link.parent < 0 ? articulation.X_WA : X_WL[link.parent]) * joint.X_PJ * X_JL);
  }
  return X_WL;
}

}  // namespace haptic
