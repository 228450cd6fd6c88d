/// Values that the stages of a step hand to one another, grouped by the stage that fills them. Nothing here is authoritative: all of
/// it follows from model and state, or belongs to one step.
#pragma once
#include <memory>
#include <vector>

#include "haptic_core/dynamics/tree_motion.h"
#include "haptic_core/dynamics/tree_step.h"
#include "haptic_core/geometry/volume/contact_workspace.h"
#include "haptic_core/stepping/activity.h"
#include "haptic_core/stepping/implicit_step.h"
#include "haptic_core/stepping/own_rate.h"
#include "haptic_core/world/applied_wrench.h"
#include "haptic_core/world/comparator.h"
#include "haptic_core/world/contact_reports.h"
#include "haptic_core/world/counted_work.h"
#include "haptic_core/world/hands.h"
#include "haptic_core/world/islands.h"
#include "haptic_core/world/ledger.h"
#include "haptic_core/world/link_forces.h"
#include "haptic_core/world/pair_search.h"
#include "haptic_core/world/placement.h"
#include "haptic_core/world/seams.h"
#include "haptic_core/world/stage_clock.h"
#include "haptic_core/world/visits.h"

namespace haptic {

/// Geometry of contacts.
struct ContactWork {
  ContactWorkspace workspace;    ///< for one contact at a time
  Seams seams;                   ///< for normals of joined pieces

  explicit ContactWork(const Model& model);  ///< set-up: room for all links and contacts
};

/// Trees that flow (stepping/flow.h), by world index.
struct FlowWork {
  std::vector<double> q_start, v_start;  ///< before
  std::vector<double> pull, v_half;      ///< see SteppedTree
  TreeStepScratch scratch;       ///< of the steps in tree_step.h

  explicit FlowWork(const Model& model);  ///< set-up: room for all velocities
};

/// Scratch of every stage of a step; one per world.
struct Work {
  Visits visits;                 ///< stepping/activity
  Placement placement;           ///< placement
  SearchWork search;             ///< pair_search
  HandWork hands;                ///< hands
  ContactWork contacts;          ///< contact_evaluation
  FlowWork motion;               ///< stepping/flow
  ContactReports reported;       ///< stages that evaluate contacts, `activity`
  double position_error = 0;     ///< of the island that errs most, as its attempt foresees [m]
  double wrench_error = 0;       ///< largest wrench that a solve of the step left out of balance [N]
  double impact = 0;             ///< energy of approach of the contacts that began in the step [J]
  bool stopped = false;          ///< a step lost a number or made energy: no other is taken
  Islands islands;               ///< islands
  std::unique_ptr<stepping::ImplicitWork> implicit;  ///< stepping/implicit_islands; null: no island is solved
  stepping::Activity activity;   ///< step, between two steps `World`
  stepping::RateWork rates;      ///< stepping/turns
  LedgerSums sums;               ///< ledger
  std::vector<std::unique_ptr<TreeMotion>> joints;  ///< by tree; null: joints without laws of their own
  WrenchWork wrenches;           ///< applied_wrench
  CountedWork counted;           ///< every stage
  std::unique_ptr<Comparator> comparator;  ///< null: the rules of stepping/advance.h
  StageClock clock;                                 ///< on only while stages are measured

  explicit Work(const Model& model);  ///< set-up: everything that a step needs, so that it allocates nothing
  ~Work();
  /// (in realtime) Books a contact that began at a speed of approach [m/s]. What bodies gain by falling for a step is none.
  void noteImpact(double speed, double reduced_mass, double fall) noexcept {
    if (speed > fall) impact += 0.5 * reduced_mass * speed * speed;
  }
  /// (in realtime) Until the work is moved or destroyed.
  LedgerView ledgerView(const Model& model) { return {model, visits, hands, placement, sums}; }
};

/// The state that a definition starts from, everything in `work` placed for it. Throws SetupError where loops do not
/// close, bodies that never move overlap, or a hand cannot hold its link.
State initialState(const Model& model, Work& work);

}  // namespace haptic
