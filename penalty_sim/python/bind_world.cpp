#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <utility>

#include "haptic_core/world/led_motion.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/runaway.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/work.h"
#include "python/bindings.h"

namespace haptic::python {
namespace {

constexpr int kStepsPerLook = 1000;  // between two looks for Ctrl-C: 10 ms and more

template <class NameOf>
SetupError unknownName(const std::string& kind, const std::string& name, int count, NameOf nameOf) {
  std::string known;
  for (int i = 0; i < count; ++i) known += (i ? ", " : "") + nameOf(i);
  return SetupError(kind + " '" + name + "'", "is not in this world",
                    known.empty() ? "it has none" : "it has: " + known);
}

/// ContactReport as NumPy sees it.
py::dtype contactType() {
  static const ContactReport sample;
  py::list names, formats, offsets;
  const auto field = [&](const char* name, const char* format, const void* place) {
    names.append(name), formats.append(format);
    offsets.append(static_cast<const char*>(place) - reinterpret_cast<const char*>(&sample));
  };
  field("link_a", "i4", &sample.link_a), field("link_b", "i4", &sample.link_b);
  field("point", "(3,)f8", sample.X_WP.p.data());
  field("normal", "(3,)f8", sample.X_WP.R.data() + 6);  // by column: the third is z of the patch
  field("torque", "(3,)f8", sample.F_BP_W.torque.data()),
      field("force", "(3,)f8", sample.F_BP_W.force.data());
  field("normal_force", "f8", &sample.normal_force), field("volume", "f8", &sample.volume);
  field("area", "f8", &sample.area), field("depth", "f8", &sample.depth),
      field("sticking", "?", &sample.sticking);
  py::dict type;
  type["names"] = names, type["formats"] = formats, type["offsets"] = offsets,
  type["itemsize"] = sizeof(ContactReport);
  return py::dtype::from_args(type);
}

py::array contacts(const py::object& self) {
  World& world = self.cast<SeenWorld&>().world();
  world.state();  // takes back what sleeps: its contacts stand with the others then
  const int count = world.contactCount();
  static const py::dtype& type =
      *new py::dtype(contactType());  // never destroyed: at exit there is no interpreter to do it
  if (count == 0) return py::array(type, std::vector<py::ssize_t>{0});
  return view(type, {count}, {sizeof(ContactReport)}, &world.contact(0), self);
}

/// View of a field of every link's place.
py::array placed(const py::object& self, bool rotations) {
  SeenWorld& seen = self.cast<SeenWorld&>();
  seen.takeWritten();
  const std::vector<LinkWork>& links = seen.world().work().placement.link;
  const auto count = static_cast<py::ssize_t>(links.size());
  constexpr py::ssize_t kLink = sizeof(LinkWork), kNumber = sizeof(double);
  if (rotations)
    return view(py::dtype::of<double>(), {count, 3, 3}, {kLink, kNumber, 3 * kNumber}, links[0].X_WL.R.data(),
                self);
  return view(py::dtype::of<double>(), {count, 3}, {kLink, kNumber}, links[0].X_WL.p.data(), self);
}

/// {link: (slice of q, slice of v)} of what can move.
py::dict coordinates(SeenWorld& seen) {
  const Model& model = seen.world().model();
  py::dict found;
  for (const ModelTree& tree : model.trees) {
    for (int l = 0; l < tree.model->linkCount(); ++l) {
      const LinkModel& link = tree.model->link(l);
      if (link.dof == 0 && !link.floating) continue;
      const bool last = l + 1 == tree.model->linkCount();
      const int q = tree.q + link.q, q_end = tree.q + (last ? tree.model->nq() : tree.model->link(l + 1).q);
      const int v = tree.v + link.v, v_end = tree.v + (last ? tree.model->nv() : tree.model->link(l + 1).v);
      found[py::str(model.links[static_cast<std::size_t>(tree.link + l)].name)] =
          py::make_tuple(py::slice(q, q_end, 1), py::slice(v, v_end, 1));
    }
  }
  return found;
}

void assign(double* to, std::size_t size, const char* what,
            const py::array_t<double, py::array::c_style | py::array::forcecast>& from) {
  if (from.ndim() != 1 || static_cast<std::size_t>(from.size()) != size) {
    throw SetupError(what, "has " + std::to_string(size) + " numbers, not " + std::to_string(from.size()),
                     "give one array of that length");
  }
  checkNumbers(what, from.data(), from.size());
  std::copy_n(from.data(), size, to);
}

void command(SeenWorld& seen, const std::string& name, const JointCommand& command) {
  if (!seen.world().setJointCommand(seen.joint(name), command)) {
    throw SetupError("joint '" + name + "'", "does not obey commands",
                     "give it a drive in the scene file (urdf/scenes/README.md)");
  }
}

void defineReports(py::module_& m) {
  py::class_<EnergyLedger>(m, "EnergyLedger", "Where the energy of a world is and went [J].")
      .def_readonly("kinetic", &EnergyLedger::kinetic, "of all links")
      .def_readonly("potential", &EnergyLedger::potential, "of gravity")
      .def_readonly("elastic", &EnergyLedger::elastic, "in contacts")
      .def_readonly("tangential", &EnergyLedger::tangential, "in the friction springs")
      .def_readonly("damping", &EnergyLedger::damping, "dissipated since the start")
      .def_readonly("friction", &EnergyLedger::friction, "dissipated since the start")
      .def_readonly("stilled", &EnergyLedger::stilled, "of `damping`: motion of islands that were brought to rest")
      .def_readonly("turning", &EnergyLedger::turning,
                    "taken out because contact normals turned, since the start")
      .def_readonly("external", &EnergyLedger::external, "work of hands and drives since the start")
      .def_property_readonly("total", &EnergyLedger::total, "kinetic + potential + elastic + tangential")
      .def_property_readonly("balance", &EnergyLedger::balance, "constant up to the step's error");
  py::class_<StepReport>(m, "StepReport", "What the last step did.")
      .def_readonly("step", &StepReport::step, "index since load")
      .def_readonly("pairs", &StepReport::pairs, "pairs of shapes whose boxes overlap")
      .def_readonly("contacts", &StepReport::contacts, "pairs of shapes that touch")
      .def_readonly("waiting", &StepReport::waiting, "bodies that are stepped at a rate of their own, and were left out of this step")
      .def_readonly("lag", &StepReport::lag, "longest time since the last step of one of them [s]")
      .def_readonly("work", &StepReport::work, "counted work of the step [1]: `World.budget` bounds it")
      .def_readonly("standing", &StepReport::standing, "bodies at rest, whose steps are left out until something comes near")
      .def_readonly("iterations", &StepReport::iterations, "of the solve; 0: all flowed")
      .def_readonly("residual", &StepReport::residual,
                    "largest speed that an implicit solve left to change [m/s]")
      .def_readonly("position_error", &StepReport::position_error,
                    "that the step adds, by its own estimate: of the island that errs most [m]")
      .def_readonly("parts", &StepReport::parts,
                    "solves of an island after one another, the most of any: more than 1 where friction changed or something was fast")
      .def_readonly("finite", &StepReport::finite, "False: a number was lost and the world stopped")
      .def_readonly("flags", &StepReport::flags, "what was dropped: StepFlag in world/report.h; 0: nothing");
}

using WorldClass = py::class_<SeenWorld>;

/// Throws SetupError when the world has no pointer i.
void checkPointer(SeenWorld& w, int i) {
  const int count = w.world().pointerCount();
  if (i < 0 || i >= count) throw SetupError("pointer " + std::to_string(i), "is not in this world", "it has " + std::to_string(count));
}

/// Positions and velocities, whole and by link.
void defineMotion(WorldClass& world) {
  world
      .def_property(
          "q",
          [](const py::object& self) {
            SeenWorld& w = self.cast<SeenWorld&>();
            return vectorView(w.q(), static_cast<py::ssize_t>(w.world().state().q.size()), self, true);
          },
          [](SeenWorld& w, const py::array_t<double, py::array::c_style | py::array::forcecast>& q) {
            assign(w.q(), w.world().state().q.size(), "q", q);
          },
          "positions, a view; what is written acts from the next step or reading on. See `coordinates`.")
      .def_property(
          "v",
          [](const py::object& self) {
            SeenWorld& w = self.cast<SeenWorld&>();
            return vectorView(w.v(), static_cast<py::ssize_t>(w.world().state().v.size()), self, true);
          },
          [](SeenWorld& w, const py::array_t<double, py::array::c_style | py::array::forcecast>& v) {
            assign(w.v(), w.world().state().v.size(), "v", v);
          },
          "velocities, a view like q")
      .def_property_readonly("coordinates", &coordinates,
                             "{link: (slice of q, slice of v)}. Joints of one degree: angle or displacement, "
                             "and its rate. Floating "
                             "links: centre of mass in W [m] and quaternion w, x, y, z; angular velocity and "
                             "velocity of the centre, in W.")
      .def_property_readonly(
          "positions", [](const py::object& self) { return placed(self, false); },
          "origins of the links in W, links x 3 [m], a view")
      .def_property_readonly(
          "rotations", [](const py::object& self) { return placed(self, true); },
          "R_WL of the links, links x 3 x 3, a view")
      .def(
          "pose",
          [](SeenWorld& w, const std::string& name) {
            w.takeWritten();
            return matrixOf(w.world().linkPose(w.link(name)));
          },
          py::arg("link"), "X_WL, 4 x 4")
      .def(
          "twist",
          [](SeenWorld& w, const std::string& name) {
            w.takeWritten();
            return w.world().linkTwist(w.link(name)).vector();
          },
          py::arg("link"), "V_WL at the link's origin, in W: angular [rad/s], linear [m/s]")
      .def_property_readonly(
          "contacts", &contacts,
          "of the last step, a view with fields link_a, link_b, point [m], normal (from a to b), torque [N "
          "m] and force [N] "
          "on b about point, normal_force [N], volume [m³], area [m²], depth [m], sticking; all in W")
      .def_property_readonly(
          "report", [](SeenWorld& w) -> const StepReport& { return w.world().report(); },
          py::return_value_policy::reference_internal, "of the last step")
      .def_property_readonly(
          "energy", [](SeenWorld& w) -> const EnergyLedger& { return w.world().report().energy; },
          py::return_value_policy::reference_internal, "the ledger after the last step");
}

/// What moves it besides gravity.
void defineCommands(WorldClass& world) {
  using Drive = JointDef::Drive;
  world
      .def(
          "command",
          [](SeenWorld& w, const std::string& joint, const py::object& position, const py::object& velocity,
             double effort) {
            const bool at = !position.is_none(), moves = !velocity.is_none();
            command(w, joint,
                    {at      ? Drive::kPosition
                     : moves ? Drive::kVelocity
                             : Drive::kEffort,
                     at ? checked("position", position.cast<double>()) : 0, moves ? checked("velocity", velocity.cast<double>()) : 0,
                     checked("effort", effort)});
          },
          py::arg("joint"), py::arg("position") = py::none(), py::arg("velocity") = py::none(),
          py::arg("effort") = 0.0,
          "What the joint's drive does from the next step on: hold a position [rad or m], run at a velocity, "
          "or give an effort [N m or N].")
      .def(
          "aim_pointer",
          [](SeenWorld& w, int i, const Matrix4& X_WP, const Vector6& V_WP) {
            checkPointer(w, i);
            w.world().setPointerTarget(i, poseOf(X_WP), twistOf("V_WP", V_WP));
          },
          py::arg("index"), py::arg("X_WP"), py::arg("V_WP") = Vector6(Vector6::Zero()),
          "Where the hand wants the pointer's frame at the end of the next step.")
      .def(
          "pointer_pose",
          [](SeenWorld& w, int i) {
            checkPointer(w, i);
            w.takeWritten();
            return matrixOf(w.world().pointerPose(i));
          },
          py::arg("index"), "X_WP, 4 x 4: the frame that the scene names, also where it is fixed to another link.")
      .def(
          "pointer_wrench",
          [](SeenWorld& w, int i) {
            checkPointer(w, i);
            return w.world().pointerWrench(i).vector();
          },
          py::arg("index"),
          "Wrench of the world on a pointer in the last step, about its frame's origin, in W: torque, force.")
      .def(
          "pointer_force_error",
          [](SeenWorld& w, int i) {
            checkPointer(w, i);
            return w.world().pointerForceError(i);
          },
          py::arg("index"), "What the last step says of the error of that force [N].")
      .def(
          "tune",
          [](SeenWorld& w, double stiffness, double friction) {
            WorldTuning tuning = w.world().tuning();
            tuning.stiffness_scale = checked("stiffness_scale", stiffness), tuning.friction_scale = checked("friction_scale", friction);
            w.world().tune(tuning);
          },
          py::arg("stiffness_scale") = 1.0, py::arg("friction_scale") = 1.0,
          "Factors on every pair's stiffness and friction.")
      .def_property(
          "budget", [](SeenWorld& w) { return w.world().tuning().budget; },
          [](SeenWorld& w, double units) {
            WorldTuning tuning = w.world().tuning();
            tuning.budget = checked("budget", units, 0);
            w.world().tune(tuning);
          },
          "Counted work that a step may take (StepReport.work) [1]; 0: any. Where it ends islands far from hands wait longer, and\n"
          "solves end earlier: flag 1024 of the report.")
      .def_property(
          "gravity", [](SeenWorld& w) { return Vector3(w.world().settings().gravity); },
          [](SeenWorld& w, const Vector3& gravity) {
            WorldTuning tuning = w.world().tuning();
            tuning.gravity = checked("gravity", gravity);
            w.world().tune(tuning);
          },
          "in W [m/s²], at most 1000; a reset keeps it");
}

/// What acts on bodies from outside.
void defineActors(WorldClass& world) {
  world
      .def(
          "apply_wrench",
          [](SeenWorld& w, const std::string& link, const Vector6& wrench, double duration, const Vector3& point,
             const std::string& frame) {
            if (frame != "world" && frame != "link") {
              throw SetupError("wrench", "frame '" + frame + "' is unknown", "write world or link");
            }
            w.takeWritten();
            const Wrench F{checked("wrench", wrench).head<3>(), wrench.tail<3>()};
            w.world().applyWrench(w.link(link), {F, checked("point", point), frame == "link"}, checked("duration", duration, 0));
          },
          py::arg("link"), py::arg("wrench"), py::arg("duration"), py::arg("point") = Vector3(Vector3::Zero()),
          py::arg("frame") = "world",
          "A wrench on a link for a time [s] of whole steps: torque [N m], force [N], in the axes of the world or of the link, about a "
          "point of the link [m]. 0 s ends what acts on it.")
      .def(
          "set_body_pose",
          [](SeenWorld& w, const std::string& link, const Matrix4& X_WL, const Vector6& V_WL) {
            w.takeWritten();
            w.world().setBodyPose(w.link(link), poseOf(X_WL), twistOf("V_WL", V_WL));
            w.remember();
          },
          py::arg("link"), py::arg("X_WL"), py::arg("V_WL") = Vector6(Vector6::Zero()),
          "Puts a body on a floating joint elsewhere, with this twist at its link's origin, in W. Its contacts begin anew.")
      .def(
          "set_joint_positions",
          [](SeenWorld& w, const std::map<std::string, double>& positions) {
            w.takeWritten();
            std::vector<std::pair<int, double>> by_index;
            for (const auto& [name, position] : positions) by_index.emplace_back(w.joint(name), checked("position", position));
            w.world().setJointPositions(by_index);
            w.remember();
          },
          py::arg("positions"), "{joint: position [rad or m]}: puts joints elsewhere, at rest; loops and followers close from there.")
      .def(
          "lead",
          [](SeenWorld& w, const std::string& motion, const Matrix4& X_WL, double duration, const Vector6& V_WL) {
            const int i = w.world().motionIndex(motion);
            if (i < 0) {
              throw unknownName("motion", motion, w.world().motionCount(), [&](int k) { return w.world().motion(k).name; });
            }
            const Pose X = poseOf(X_WL);
            if (w.world().leadBody(i, {X.p, Quaternion(X.R).normalized(), twistOf("V_WL", V_WL)}, checked("duration", duration, 0))) return;
            throw SetupError("motion '" + motion + "'", "follows a file", "lead what the scene leaves to topic or tf");
          },
          py::arg("motion"), py::arg("X_WL"), py::arg("duration"), py::arg("V_WL") = Vector6(Vector6::Zero()),
          "A body that is led from outside goes to a pose, where it arrives with this twist after so many seconds.");
}

/// All of it, to go back to and to compare.
void defineStates(WorldClass& world) {
  world
      .def(
          "save",
          [](SeenWorld& w) {
            w.takeWritten();
            return py::array_t<double>(py::cast(w.world().save()));
          },
          "The complete state, contact memory included: a copy.")
      .def(
          "restore",
          [](SeenWorld& w, const std::vector<double>& state) {
            checkNumbers("saved state", state.data(), static_cast<py::ssize_t>(state.size()));
            w.world().restore(state);
            w.remember();
          },
          py::arg("state"), "Goes on from what `save` gave, bit for bit.")
      .def(
          "hash",
          [](SeenWorld& w) {
            w.takeWritten();
            return w.world().hash();
          },
          "of the complete state: equal for equal bits")
      .def(
          "plan", [](SeenWorld& w) { return w.world().planText(); },
          "what the scene was compiled to, and what was left out");
}

}  // namespace

void checkNumbers(const std::string& what, const double* numbers, py::ssize_t count, double least) {
  for (py::ssize_t i = 0; i < count; ++i) {
    if (std::isfinite(numbers[i]) && numbers[i] >= least) continue;
    const std::string place = count > 1 ? what + "[" + std::to_string(i) + "]" : what, range = std::isfinite(least) ? " >= 0" : "";
    throw SetupError(place, "is " + std::to_string(numbers[i]), "give a finite number" + range);
  }
}

Pose poseOf(const Matrix4& m) {
  const Matrix3 R = m.topLeftCorner<3, 3>();
  constexpr double kRounding = 1e-6;  // of a matrix that was written with six digits
  if (!((R * R.transpose() - Matrix3::Identity()).cwiseAbs().maxCoeff() < kRounding) ||
      !(R.determinant() > 0) || !m.allFinite()) {
    throw SetupError("pose", "is no rotation and position",
                     "give a 4 x 4 matrix [R p; 0 0 0 1] with R orthonormal");
  }
  return {R, m.topRightCorner<3, 1>()};
}

SeenWorld::SeenWorld(const SceneDef& scene) : own_(std::make_unique<World>(scene.world)), world_(own_.get()) {
  remember();
}
SeenWorld::SeenWorld(World& world, std::shared_ptr<void> owner) : owner_(std::move(owner)), world_(&world) {
  remember();
}

int SeenWorld::link(const std::string& name) const {
  const int i = world_->linkIndex(name);
  if (i < 0) throw unknownName("link", name, world_->linkCount(), [&](int k) { return world_->linkName(k); });
  return i;
}

int SeenWorld::joint(const std::string& name) const {
  const int i = world_->jointIndex(name);
  if (i < 0)
    throw unknownName("joint", name, world_->jointCount(), [&](int k) { return world_->jointName(k); });
  return i;
}

void SeenWorld::remember() {
  seen_q_ = world_->q();
  seen_v_ = world_->v();
}

void SeenWorld::takeWritten() {
  const auto same = [](const std::vector<double>& a, const std::vector<double>& b) {
    return std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
  };
  if (same(world_->q(), seen_q_) && same(world_->v(), seen_v_)) return;
  try {
    checkNumbers("q", q(), static_cast<py::ssize_t>(seen_q_.size()));
    checkNumbers("v", v(), static_cast<py::ssize_t>(seen_v_.size()));
  } catch (const SetupError&) {  // the world stays as it was
    std::copy(seen_q_.begin(), seen_q_.end(), q());
    std::copy(seen_v_.begin(), seen_v_.end(), v());
    throw;
  }
  State written = world_->state();
  std::fill(written.mode.begin(), written.mode.end(), TreeMode::kPut);
  std::fill(written.last_step.begin(), written.last_step.end(), 0.0);  // it does not go on from where it was
  world_->restore(written.pack());
  renewSupply(world_->model(), world_->work(), written);  // a body thrown from here has not run away
  world_->restore(written.pack());
  remember();
}

void SeenWorld::step(int count) {
  checked("count", count, 0);
  takeWritten();
  for (int i = 0; i < count; ++i) {
    world_->step();
    if (i % kStepsPerLook == kStepsPerLook - 1) heedSignals();
  }
  remember();
}

void bindWorld(py::module_& m) {
  defineReports(m);
  WorldClass world(m, "World", "Articulated bodies in contact, stepped at a fixed rate.");
  world
      .def(py::init([](const py::object& scene) { return std::make_unique<SeenWorld>(sceneFrom(scene)); }),
           py::arg("scene"), "Of a Scene, or of a file or name as Scene takes it.")
      .def("step", &SeenWorld::step, py::arg("count") = 1, "Advances by `count` steps of `h`.")
      .def_property_readonly(
          "h", [](SeenWorld& w) { return w.world().settings().step; }, "step [s]")
      .def_property_readonly(
          "time", [](SeenWorld& w) { return w.world().time(); }, "simulated [s]")
      .def_property_readonly(
          "links",
          [](SeenWorld& w) {
            std::vector<std::string> names;
            for (int i = 0; i < w.world().linkCount(); ++i) names.push_back(w.world().linkName(i));
            return names;
          },
          "names, in the order of positions and rotations")
      .def("link", &SeenWorld::link, py::arg("name"), "index of a link")
      .def_property_readonly(
          "joints",
          [](SeenWorld& w) {
            std::vector<std::string> names;
            for (int i = 0; i < w.world().jointCount(); ++i) names.push_back(w.world().jointName(i));
            return names;
          },
          "names of the joints of one degree of freedom")
      .def("__repr__", [](SeenWorld& w) {
        return "<haptic.World of " + std::to_string(w.world().linkCount()) + " links at " +
               std::to_string(w.world().time()) + " s>";
      });
  defineMotion(world);
  defineSensors(world);
  defineCommands(world);
  defineActors(world);
  defineStates(world);
}

}  // namespace haptic::python
