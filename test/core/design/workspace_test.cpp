// Oracles: closed forms, Taylor's theorem at random poses, and the tension solver, which knows nothing of faces.
#include "haptic_core/design/workspace.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "haptic_core/spidar/tension_distribution.h"

namespace haptic {
namespace workspace_test {

DeviceDef device(const std::string& name) {
  return loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/" + name + ".yaml");
}

struct Random {
  std::mt19937_64 generator{7};
  double uniform(double size = 1) { return std::uniform_real_distribution<double>(-size, size)(generator); }
  Vector6 in(const PoseCell& cell) {
    Vector6 at;
    for (int j = 0; j < 6; ++j) at[j] = cell.centre[j] + uniform() * cell.half[j];
    return at;
  }
  Vector3 direction() {
    Vector3 v;
    do v = {uniform(), uniform(), uniform()};
    while (v.squaredNorm() > 1 || v.squaredNorm() < 1e-4);
    return v.normalized();
  }
};

RowBounds rowsAt(const CellRows& rows, const Vector6& at) {
  PoseCell point;
  point.centre = at;
  RowBounds out;
  rows.evaluate(point, out);
  return out;
}

/// Greatest scaled wrench that the strings keep away from any required one: the distance to a convex set is convex, so each step
/// to the required wrench that is farthest along the error climbs.
double missing(const DeviceDef& def, const GripPose& pose, const RequiredWrench& required, Random& random) {
  DeviceDef unlimited = def;
  unlimited.lambda = 1e-9;
  unlimited.border_lambda = 0;
  const StringKinematics kinematics(unlimited);
  TensionDistribution tensions(unlimited, kinematics);
  tensions.setStructure(kinematics.scaledStructure(pose));
  double worst = 0;
  for (int start = 0; start < 20; ++start) {
    Wrench F;
    F.force = required.force * random.direction();
    F.torque = def.dof >= 6 ? Vector3(required.torque * random.direction()) : Vector3::Zero();
    for (int step = 0; step < 8; ++step) {
      const TensionReport& r = tensions.solve(F);
      worst = std::max(worst, r.error);
      const Wrench e = F - r.F_G_B;
      if (r.error < 1e-9) break;
      if (e.force.norm() > 0) F.force = required.force * e.force.normalized();
      if (e.torque.norm() > 0) F.torque = required.torque * e.torque.normalized();
    }
  }
  return worst;
}

// Faces of the rhombic dodecahedron of four strings along the diagonals of a tetrahedron lie across the cube's edges: two strings
// in the plane, one at √⅔ to either side.
TEST(PresentableSet, TetrahedronInClosedForm) {
  const DeviceDef def = device("spidar_4");
  const CellRows rows(def);
  const double span = def.strings[0].max_tension - def.strings[0].min_tension;
  const PresentableSet set(def, {1, 0});
  const RowBounds home = rowsAt(rows, Vector6::Zero());
  EXPECT_NEAR(set.largestForce(home), std::sqrt(2.0 / 3) * span, 1e-9);
  EXPECT_NEAR(set.margin(home), std::sqrt(2.0 / 3) * span - 1, 1e-9);
}

TEST(PresentableSet, AgreesWithTheTensionSolver) {
  Random random;
  int inside = 0, outside = 0;
  for (const char* name : {"spidar_4", "spidar_g6x3r", "spidar_g6t1", "spidar_i7", "spidar_g7"}) {
    const DeviceDef def = device(name);
    const RequiredWrench required{0.8, def.dof >= 6 ? 0.8 * StringKinematics(def).knotRadius() : 0};
    const CellRows rows(def);
    const PresentableSet set(def, required);
    PoseCell where = translations(def);
    where.half *= 0.6;
    if (def.dof >= 6) where.half.tail<3>().setConstant(0.4);
    for (int i = 0; i < 60; ++i) {
      const Vector6 at = random.in(where);
      const RowBounds row = rowsAt(rows, at);
      if (!row.bounded) continue;
      const double margin = set.margin(row);
      if (std::fabs(margin) < 1e-3) continue;
      const double lost = missing(def, where.pose(at), required, random);
      if (margin > 0)
        EXPECT_LT(lost, 1e-5) << name << " " << at.transpose();
      else
        EXPECT_GT(lost, 1e-5) << name << " " << at.transpose();
      ++(margin > 0 ? inside : outside);
    }
  }
  EXPECT_GT(inside, 30);
  EXPECT_GT(outside, 30);
}

TEST(CellRows, BoundsHoldThroughoutACell) {
  Random random;
  double closest = 0;
  for (const char* name : {"spidar_4", "spidar_g6x3r", "spidar_g7"}) {
    const DeviceDef def = device(name);
    const CellRows rows(def);
    for (int i = 0; i < 200; ++i) {
      PoseCell cell;
      for (int j = 0; j < (def.dof == 3 ? 3 : 6); ++j) {
        cell.centre[j] = random.uniform(j < 3 ? 0.02 : 0.5);
        cell.half[j] = std::fabs(random.uniform(j < 3 ? 0.01 : 0.1)) * (i % 3 != 0 || j < 3);
      }
      RowBounds bounds;
      rows.evaluate(cell, bounds);
      ASSERT_TRUE(bounds.bounded);
      const Vector6 at = random.in(cell);
      const RowBounds there = rowsAt(rows, at);
      for (int s = 0; s < bounds.strings; ++s) {
        RowBounds::Row linear = bounds.row[s];
        for (int m = 0; m < bounds.moves; ++m) linear += (at - cell.centre)[bounds.moving[m]] * bounds.slope[s][m];
        const double error = (there.row[s] - linear).norm(), change = (there.row[s] - bounds.row[s]).norm();
        EXPECT_LE(error, bounds.bend[s] + 1e-12);
        EXPECT_LE(change, bounds.spread[s] + 1e-12);
        closest = std::max(closest, error / bounds.bend[s]);
      }
    }
  }
  EXPECT_GT(closest, 0.2) << "the bound is not far from what it bounds";
}

/// Certified cells that the exact solve of `def` contradicts at one of `poses` random poses.
int contradicted(const Workspace& w, const DeviceDef& def, const WorkspaceSettings& settings, int poses) {
  Random random;
  const CellJudge judge(def, w.searched, settings);
  int wrong = 0;
  for (const bool is_inside : {true, false}) {
    const std::vector<PoseCell>& cells = is_inside ? w.inside : w.outside;
    for (int i = 0; i < poses && !cells.empty(); ++i) {
      const PoseCell& cell = cells[random.generator() % cells.size()];
      wrong += judge.contains(random.in(cell)) != is_inside;
    }
  }
  return wrong;
}

TEST(Workspace, CertifiedCellsAgreeWithTheExactSolve) {
  for (const char* name : {"spidar_4", "spidar_g6x5r"}) {
    const DeviceDef def = device(name);
    WorkspaceSettings settings;
    settings.required = {1, def.dof >= 6 ? 0.015 : 0};
    settings.work = 500000;
    PoseCell near, turns;
    near.half.head<3>() = (def.dof == 3 ? 0.8 : 0.4) * translations(def).half.head<3>();
    turns.half.tail<3>().setConstant(0.4);
    for (const PoseCell& searched : {near, turns}) {
      if (def.dof == 3 && searched.half[3] > 0) continue;
      const Workspace w = certifyWorkspace(def, searched, settings);
      double volume = 0;
      for (const std::vector<PoseCell>* cells : {&w.inside, &w.outside, &w.undecided})
        for (const PoseCell& cell : *cells) volume += cell.volume();
      EXPECT_NEAR(volume, searched.volume(), 1e-9 * volume) << "a partition";
      EXPECT_GT(w.inside_share, 0.05);
      EXPECT_EQ(contradicted(w, def, settings, 2000), 0) << name;
      WorkspaceSettings harder = settings;
      harder.required.force *= 4;
      EXPECT_GT(contradicted(w, def, harder, 2000), 0) << "the comparison can fail";
      Random random;
      const CellJudge judge(def, searched, settings);
      for (const PoseCell* box : {&w.box, &w.home_box})
        for (int i = 0; i < 200 && box->half.maxCoeff() > 0; ++i) EXPECT_TRUE(judge.contains(random.in(*box)));
      for (const PoseCell* ball : {&w.ball, &w.home_ball})
        for (int i = 0; i < 200; ++i) {
          Vector6 at = ball->centre;
          const double radius = ball->half.maxCoeff();
          (searched.half[0] > 0 ? at.head<3>() : at.tail<3>()) += 0.999 * radius * random.direction();
          EXPECT_TRUE(radius == 0 || judge.contains(at));
        }
    }
  }
}

// Strings that all pull upwards present nothing all round, wherever the grip is.
TEST(Workspace, IsEmptyWhereStringsDoNotSurroundTheGrip) {
  DeviceDef def = device("spidar_g6x3r");
  for (StringDef& s : def.strings) s.p_BE.z() = 0.2 + 0.02 * s.p_BE.z();
  PoseCell near;
  near.half.head<3>().setConstant(0.02);
  WorkspaceSettings settings;
  settings.work = 2000000;
  const Workspace w = certifyWorkspace(def, near, settings);
  EXPECT_TRUE(w.inside.empty());
  EXPECT_LT(w.undecided_share, 0.02);
  EXPECT_EQ(w.ball.half.maxCoeff(), 0);
}

}  // namespace workspace_test
}  // namespace haptic
