#include "scene/link_inertia.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "haptic_core/base/symmetric_matrix.h"
#include "scene/excited_inertia.h"

namespace haptic {
namespace {

/// Steiner's term: a point mass m at r.
Matrix3 pointInertia(double mass, const Vector3& r) {
  return mass * (r.squaredNorm() * Matrix3::Identity() - r * r.transpose());
}

/// A link without shape and inertia that some motion of a joint moves alone gets this share of the mean link mass, as a ball of this
/// radius: small beside its neighbours, large enough that nothing divides by almost zero.
constexpr double kEstimateMassShare = 0.01, kEstimateRadius = 0.02;

}  // namespace

LinkInertia readInertia(const RobotFile& robot, const LinkXml& link) {
  LinkInertia inertia;
  const XmlElement* const given = link.element->FirstChildElement("inertial");
  if (!given) return inertia;
  const Pose X_LC = readOrigin(robot.xml, *given);
  const XmlElement& moments = *given->FirstChildElement("inertia");
  const auto entry = [&](const char* name) { return *readNumber(robot.xml, moments, name); };
  const double ixx = entry("ixx"), iyy = entry("iyy"), izz = entry("izz");
  const double ixy = entry("ixy"), ixz = entry("ixz"), iyz = entry("iyz");
  Matrix3 I;
  I << ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz;
  inertia.mass = *readNumber(robot.xml, *given->FirstChildElement("mass"), "value");
  inertia.p_LC = X_LC.p;
  inertia.I_C = X_LC.R * I * X_LC.R.transpose();
  return inertia;
}

void merge(const LinkInertia& added, const Pose& X_LM, LinkInertia& inertia) {
  const double mass = inertia.mass + added.mass;
  const Vector3 p_added = X_LM * added.p_LC;
  const Matrix3 I_added = X_LM.R * added.I_C * X_LM.R.transpose();
  if (mass <= 0) {
    inertia.I_C += I_added;
    return;
  }
  const Vector3 com = (inertia.mass * inertia.p_LC + added.mass * p_added) / mass;
  inertia.I_C +=
      pointInertia(inertia.mass, inertia.p_LC - com) + I_added + pointInertia(added.mass, p_added - com);
  inertia.p_LC = com;
  inertia.mass = mass;
}

LinkInertia inertiaOfShapes(const std::vector<CollisionDef>& collisions, double density) {
  LinkInertia sum;
  for (const CollisionDef& collision : collisions) {
    if (!collision.shape->bounded()) continue;
    const MassProperties shape = collision.shape->massProperties(density);
    merge({shape.mass, shape.com, shape.I_com}, collision.X_LS, sum);
  }
  return sum;
}

Matrix3 momentsOfShapes(const std::vector<CollisionDef>& collisions, double mass) {
  const LinkInertia solid = inertiaOfShapes(collisions, 1);
  if (!(solid.mass > 0)) return 0.4 * mass * kEstimateRadius * kEstimateRadius * Matrix3::Identity();
  return mass / solid.mass * solid.I_C;
}

namespace {

/// Masses of one tree that a joint's law feels beside its heaviest link; what is lighter is rounding (1e-16) to the eighth digit.
constexpr double kLeastMassShare = 1e-8;

Vector3 momentsOf(const Matrix3& I) { return principalAxes(I).value; }

/// The core bears moments that rounding made negative (dynamics/articulation.cpp).
bool isPositive(const Matrix3& I) { return momentsOf(I)[0] >= -1e-3 * std::abs(I.trace()); }

/// Replaces inertias of one tree, and says each.
class InertiaMender {
 public:
  InertiaMender(ArticulationDef& tree, const std::vector<std::string>& places, double density, LoadReport& said)
      : tree_(tree), places_(places), density_(density > 0 ? density : kEstimateDensity), said_(said) {}

  /// From the shapes where a file has no <inertial>.
  void fill(std::size_t i) {
    LinkDef& link = tree_.links[i];
    link.inertia = inertiaOfShapes(link.collisions, density_);
    if (!(link.inertia.mass > 0)) return;  // no shape: it weighs nothing, as URDF says
    std::ostringstream text;
    text << places_[i] << ": has no <inertial>: " << link.inertia.mass << " kg taken from its shapes at " << density_
         << " kg/m³; give it one";
    said_.warnings.push_back(text.str());
  }

  /// Gives link i an inertia that every motion meets: its mass spread over its shapes, or, of a link without mass, what `fill` gives.
  void replace(std::size_t i, const std::string& why) {
    LinkDef& link = tree_.links[i];
    const double mass = link.inertia.mass;
    const LinkInertia solid = inertiaOfShapes(link.collisions, density_);
    std::ostringstream text;
    text << places_[i] << ": " << why << ": ";
    if (solid.mass > 0) {
      const double share = mass > 0 ? mass / solid.mass : 1;
      link.inertia = {share * solid.mass, mass > 0 ? link.inertia.p_LC : solid.p_LC, share * solid.I_C};
      text << (mass > 0 ? "that of its shapes with " : "") << link.inertia.mass << " kg" << (mass > 0 ? "" : " taken from its shapes")
           << ", moments " << momentsOf(link.inertia.I_C).transpose() << " kg m², in its place";
    } else {
      const double given = mass > 0 ? mass : kEstimateMassShare * meanMass();
      link.inertia = {given, link.inertia.p_LC, 0.4 * given * kEstimateRadius * kEstimateRadius * Matrix3::Identity()};
      text << "a ball of 20 mm and " << given << " kg in its place";
    }
    text << "; correct <inertial>, for a solid box ixx = m (y² + z²)/12";
    said_.replaced.push_back(text.str());
  }

  double meanMass() const {
    double mass = 0;
    int known = 0;
    for (const LinkDef& link : tree_.links) {
      if (link.inertia.mass > 0) mass += link.inertia.mass, ++known;
    }
    return known > 0 ? mass / known : 1;
  }

 private:
  ArticulationDef& tree_;
  const std::vector<std::string>& places_;
  double density_;
  LoadReport& said_;
};

bool fixedToWorld(const LinkDef& link) { return link.parent < 0 && link.joint.type == JointType::kFixed; }

/// The link of the largest moment, beside which those of the others may be rounding.
const LinkDef& heaviestToTurn(const ArticulationDef& tree) {
  const auto largest = [](const LinkDef& link) { return momentsOf(link.inertia.I_C)[2]; };
  return *std::max_element(tree.links.begin(), tree.links.end(),
                           [&](const LinkDef& a, const LinkDef& b) { return largest(a) < largest(b); });
}

/// A link is replaced once: where that does not help, no inertia would.
void replaceWhereNothingIsMet(ArticulationDef& tree, const std::vector<std::string>& places,
                              InertiaMender& mender) {
  std::vector<bool> replaced(tree.links.size(), false);
  for (int i = linkWithoutInertia(tree); i >= 0; i = linkWithoutInertia(tree)) {
    const LinkInertia& inertia = tree.links[i].inertia;
    if (replaced[i]) {
      const LinkDef& heaviest = heaviestToTurn(tree);
      std::ostringstream what;
      what << "its inertia (" << inertia.mass << " kg) is lost in rounding, and so was what took its place: "
           << "the largest moments are those of link '" << heaviest.name << "' ("
           << momentsOf(heaviest.inertia.I_C).transpose() << " kg m²)";
      throw SetupError(places[i], what.str(), "correct masses, moments and positions that are far from the others");
    }
    replaced[i] = true;
    std::ostringstream why;
    why << "joint '" << tree.links[i].joint.name << "' can move what has no inertia (" << inertia.mass
        << " kg, principal moments " << momentsOf(inertia.I_C).transpose() << " kg m²)";
    mender.replace(i, why.str());
  }
}

void warnOfTriangle(const LinkDef& link, const std::string& place, std::vector<std::string>& warnings) {
  const Vector3 moments = momentsOf(link.inertia.I_C);
  // Between the two others nothing is amiss where none is given: <inertia ixx="1"/> of a link that only slides.
  if (!(moments[0] > 0) || moments[0] + moments[1] >= moments[2] * (1 - 1e-6)) return;
  std::ostringstream text;
  text << place << ": principal moments " << moments.transpose()
       << " kg m² violate the triangle inequality: no body has them; taken as given, correct them";
  warnings.push_back(text.str());
}

}  // namespace

void completeInertias(ArticulationDef& tree, const std::vector<std::string>& places, const std::vector<bool>& given, double density,
                      const OptionWords& words, LoadReport& said) {
  InertiaMender mender(tree, places, density, said);
  const bool none = std::none_of(tree.links.begin(), tree.links.end(), [](const LinkDef& link) { return link.inertia.mass > 0; });
  double heaviest = 0;
  for (std::size_t i = 0; i < tree.links.size(); ++i) {
    LinkDef& link = tree.links[i];
    if (fixedToWorld(link)) {
      if (!isPositive(link.inertia.I_C)) link.inertia.I_C.setZero();  // nothing turns it
      continue;
    }
    if (!given[i] && density <= 0 && none) {
      throw SetupError(places[i], "has no <inertial>, nor has any other moving link of '" + tree.name + "'",
                       "add <inertial>, or load with " + words.density + " (kg/m³)");
    }
    if (!given[i]) mender.fill(i);
    heaviest = std::max(heaviest, link.inertia.mass);
  }
  for (std::size_t i = 0; i < tree.links.size(); ++i) {
    LinkDef& link = tree.links[i];
    if (fixedToWorld(link)) continue;
    if (link.inertia.mass < kLeastMassShare * heaviest && tree.links.size() > 1) link.inertia.mass = 0;
    if (isPositive(link.inertia.I_C)) continue;
    std::ostringstream why;
    why << "its inertia is not positive definite (principal moments " << momentsOf(link.inertia.I_C).transpose() << " kg m²)";
    mender.replace(i, why.str());
  }
  replaceWhereNothingIsMet(tree, places, mender);
  for (std::size_t i = 0; i < tree.links.size(); ++i) {
    if (!fixedToWorld(tree.links[i])) warnOfTriangle(tree.links[i], places[i], said.warnings);
  }
}

}  // namespace haptic
