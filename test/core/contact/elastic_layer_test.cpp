// A surface's stiffness from what it is made of, against Hooke's law and layers in series.
#include "haptic_core/contact/elastic_layer.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>

#include "haptic_core/base/error.h"
#include "haptic_core/contact/contact_material.h"

namespace haptic {
namespace elastic_layer_test {

constexpr double kEps = std::numeric_limits<double>::epsilon();

// Hooke's law as compliances, inverted: the stress on a strain along z alone.
TEST(ElasticLayer, ALayerThatCannotBulgeIsAsStiffAsHookesLawSays) {
  for (const double nu : {0.0, 0.1, 0.2, 0.29, 0.3, 1.0 / 3 - 1e-9}) {
    Eigen::Matrix3d compliance = Eigen::Matrix3d::Constant(-nu);
    compliance.diagonal().setOnes();
    EXPECT_NEAR(confinement(nu), compliance.inverse()(2, 2), 1e2 * kEps) << nu;  // a condition number of 4 at most
  }
}

// Gent & Lindley: 1 + 2S², S the loaded over the free area, of half a cube of side a: a²/(4 a · a/2).
TEST(ElasticLayer, WhatKeepsItsVolumeBulgesAsHalfACubeDoes) {
  const double a = 0.1, S = a * a / (4 * a * a / 2);
  EXPECT_DOUBLE_EQ(confinement(0.5), 1 + 2 * S * S);
  EXPECT_NEAR(confinement(1.0 / 3 - 1e-9), confinement(1.0 / 3), 1e-7);  // no jump
}

TEST(ElasticLayer, TwoBodiesAreLayersInSeries) {
  for (const Solid& a : kSolids) {
    for (const Solid& b : kSolids) {
      const double L_a = 0.1, L_b = 0.03;
      ContactMaterial A, B;
      A.stiffness = surfaceStiffness(a.young_modulus, a.poisson_ratio, L_a);
      B.stiffness = surfaceStiffness(b.young_modulus, b.poisson_ratio, L_b);
      const double M_a = confinement(a.poisson_ratio) * a.young_modulus, M_b = confinement(b.poisson_ratio) * b.young_modulus;
      const double series = 1 / (L_a / (2 * M_a) + L_b / (2 * M_b));
      EXPECT_NEAR(combine(A, B, {}).stiffness, series, 10 * kEps * series) << a.name << " on " << b.name;
    }
  }
}

TEST(ElasticLayer, SolidsHaveNamesSourcesAndRatiosThatExist) {
  for (const Solid& solid : kSolids) {
    EXPECT_EQ(solidNamed(solid.name), &solid);
    EXPECT_GT(std::string(solid.source).size(), 10u);
    EXPECT_GT(solid.young_modulus, 0);
    EXPECT_TRUE(solid.poisson_ratio >= 0 && solid.poisson_ratio <= 0.5) << solid.name;
  }
  EXPECT_EQ(solidNamed("cheese"), nullptr);
}

// A value that somebody gives is not touched by what was chosen.
TEST(ElasticLayer, ChosenStiffnessHoldsWhereNobodyGivesOne) {
  ContactMaterial none, light, heavy, pointer, given;
  light.rest_stiffness = 2e6;
  heavy.rest_stiffness = 3e9;
  pointer.touch_stiffness = 4e7;
  given.stiffness = 5e5;
  const auto k = [](const ContactMaterial& a, const ContactMaterial& b) { return combine(a, b, {}).stiffness; };
  EXPECT_EQ(k(none, none), DefaultMaterial::kStiffness);
  EXPECT_EQ(k(none, light), 2e6);
  EXPECT_EQ(k(heavy, light), 3e9);  // the heavy one may lie on the light one
  EXPECT_EQ(k(heavy, pointer), 4e7);
  EXPECT_EQ(k(pointer, none), 4e7);
  for (const ContactMaterial& m : {light, heavy, pointer}) EXPECT_EQ(k(given, m), 5e5);
  ContactMaterial world;
  world.stiffness = 6e5;
  EXPECT_EQ(combine(heavy, pointer, world).stiffness, 6e5);
}

// A rigid surface is a layer without compliance: two in series, 1/(2 k_A) + 1/(2 k_B), and a pair has k = half of the series' inverse.
TEST(ElasticLayer, ARigidSurfaceAddsNoCompliance) {
  using M = ContactMaterial;
  M rigid, soft, heavy, silent;
  rigid.stiffness = M::kRigid;
  soft.stiffness = 3e6;
  heavy.rigid_stiffness = 4e11, heavy.rest_stiffness = 5e6;
  M stiff = soft;
  stiff.stiffness = 1e300;  // the limit of the mean
  EXPECT_DOUBLE_EQ(combine(rigid, soft, {}).stiffness, combine(stiff, soft, {}).stiffness);
  EXPECT_EQ(combine(rigid, heavy, {}).stiffness, 4e11);
  EXPECT_EQ(combine(heavy, rigid, {}).stiffness, 4e11);
  EXPECT_EQ(combine(heavy, silent, rigid).stiffness, 4e11) << "the scene says it";
  EXPECT_DOUBLE_EQ(combine(heavy, soft, rigid).stiffness, combine(rigid, soft, {}).stiffness) << "who says nothing is rigid";
  EXPECT_DOUBLE_EQ(combine(soft, heavy, rigid).stiffness, combine(rigid, soft, {}).stiffness);
  EXPECT_EQ(combine(soft, soft, rigid).stiffness, 3e6) << "surfaces that give a number keep it";
  EXPECT_EQ(combine(heavy, silent, {}).stiffness, 5e6);
  EXPECT_EQ(combine(heavy, rigid, soft).stiffness, 4e11) << "the scene's number is for surfaces that say nothing";
  EXPECT_EQ(combine(rigid, silent, {}).stiffness, DefaultMaterial::kRigid);
  EXPECT_EQ(combine(rigid, heavy, {}).tangential_stiffness, DefaultMaterial::kTangentialRatio * 4e11);
  M hand;
  hand.touch_stiffness = 2e5;
  EXPECT_EQ(combine(rigid, hand, {}).stiffness, 2e5) << "a hand bears no more";
  EXPECT_NO_THROW(check(rigid, "here"));
  rigid.tangential_stiffness = M::kRigid;
  EXPECT_THROW(check(rigid, "here"), SetupError);
}

}  // namespace elastic_layer_test
}  // namespace haptic
