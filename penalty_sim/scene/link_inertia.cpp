#include "scene/link_inertia.h"

#include <Eigen/Eigenvalues>
#include <sstream>

#include "haptic_core/geometry/shapes/half_space.h"

namespace haptic {
namespace {

/// Steiner's term: a point mass m at r.
Matrix3 pointInertia(double mass, const Vector3& r) {
  return mass * (r.squaredNorm() * Matrix3::Identity() - r * r.transpose());
}

/// Density of solid plastic or of a machine with its hollows; only the estimate for single links uses it.
constexpr double kEstimateDensity = 1000;
/// An intermediate link without shape and inertia (one axis of a ball joint) gets this share of the mean link
/// mass, as a ball of this radius: small beside its neighbours, large enough that nothing divides by almost
/// zero.
constexpr double kEstimateMassShare = 0.01, kEstimateRadius = 0.02;

}  // namespace

LinkInertia readInertia(const urdf::Link& link) {
  LinkInertia inertia;
  if (!link.inertial) return inertia;
  const urdf::Inertial& given = *link.inertial;
  const auto& q = given.origin.rotation;
  const Matrix3 R = Quaternion(q.w, q.x, q.y, q.z).normalized().toRotationMatrix();
  Matrix3 I;
  I << given.ixx, given.ixy, given.ixz, given.ixy, given.iyy, given.iyz, given.ixz, given.iyz, given.izz;
  inertia.mass = given.mass;
  inertia.p_LC = Vector3(given.origin.position.x, given.origin.position.y, given.origin.position.z);
  inertia.I_C = R * I * R.transpose();
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

void checkInertia(const LinkInertia& inertia, const std::string& where, std::vector<std::string>& warnings) {
  std::ostringstream text;
  if (!(inertia.mass > 0)) {
    text << "its mass is " << inertia.mass << " kg, and it moves";
    throw SetupError(where, text.str(), "give it a mass > 0, or a fixed joint");
  }
  const Vector3 moments =
      Eigen::SelfAdjointEigenSolver<Matrix3>(inertia.I_C, Eigen::EigenvaluesOnly).eigenvalues();
  // Rounding of the six numbers in the file, relative to the largest moment.
  constexpr double kRounding = 1e-9;
  if (!(moments[0] > kRounding * moments[2])) {
    text << "its inertia is not positive definite (principal moments " << moments.transpose() << " kg m²)";
    throw SetupError(where, text.str(), "correct ixx…izz; for a solid box ixx = m (y² + z²)/12");
  }
  if (moments[0] + moments[1] < moments[2] * (1 - 1e-6)) {
    text << where << ": principal moments " << moments.transpose()
         << " kg m² violate the triangle inequality: no body has them; taken as given, correct them";
    warnings.push_back(text.str());
  }
}

void fillMissingInertias(ArticulationDef& articulation, const std::vector<std::string>& places,
                         const std::vector<bool>& given, double density, std::vector<std::string>& warnings) {
  double mass = 0;
  int known = 0;
  for (std::size_t i = 0; i < articulation.links.size(); ++i) {
    if (!given[i] || articulation.links[i].inertia.mass <= 0) continue;
    mass += articulation.links[i].inertia.mass;
    ++known;
  }
  for (std::size_t i = 0; i < articulation.links.size(); ++i) {
    LinkDef& link = articulation.links[i];
    if (given[i] || link.joint.type == JointType::kFixed) continue;
    if (density <= 0 && known == 0) {
      throw SetupError(places[i],
                       "has no <inertial>, nor has any other moving link of '" + articulation.name + "'",
                       "add <inertial>, or load with --default-density 1000 (kg/m³)");
    }
    link.inertia = inertiaOfShapes(link.collisions, density > 0 ? density : kEstimateDensity);
    std::ostringstream text;
    text << places[i] << ": has no <inertial>: ";
    if (link.inertia.mass > 0) {
      text << link.inertia.mass << " kg taken from its shapes at "
           << (density > 0 ? density : kEstimateDensity) << " kg/m³";
    } else {
      const double m = known > 0 ? kEstimateMassShare * mass / known : kEstimateMassShare;
      link.inertia = {m, Vector3::Zero(), 0.4 * m * kEstimateRadius * kEstimateRadius * Matrix3::Identity()};
      text << "it has no shape either and gets " << m << " kg, a ball of 20 mm";
    }
    text << "; give it one";
    warnings.push_back(text.str());
  }
}

}  // namespace haptic
