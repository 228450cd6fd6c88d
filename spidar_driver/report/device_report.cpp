#include "spidar_driver/report/device_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "haptic_core/base/dense_matrix.h"
#include "haptic_core/design/interference.h"

namespace haptic {
namespace {

constexpr int kSamples = 25;            // of a section, along each side, where values are shown
constexpr std::size_t kBorderCells = 6000;  // that the view in 3-D draws at most

/// Text of a JSON value.
std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.5g", std::isfinite(value) ? value : 0);
  return text;
}

std::string quoted(const std::string& words) {
  std::string text = "\"";
  for (const char c : words) {
    if (c == '"' || c == '\\') text += '\\';
    text += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return text + '"';
}

template <class Values>
std::string list(const Values& values, double scale = 1) {
  std::string text = "[";
  for (int i = 0; i < static_cast<int>(values.size()); ++i) text += (i ? "," : "") + number(scale * values[i]);
  return text + "]";
}

/// The three coordinates of a region that move, in the units of the page.
struct Axes {
  int first;
  double scale;
  explicit Axes(const PoseCell& searched) : first(searched.half[0] > 0 ? 0 : 3), scale(first == 0 ? 1e3 : 180 / M_PI) {}
  std::string of(const Vector6& v) const { return list(Vector3(v.segment<3>(first)), scale); }
};

std::string boxText(const Axes& axes, const PoseCell& box) {
  return "{\"centre\":" + axes.of(box.centre) + ",\"half\":" + axes.of(box.half) + "}";
}

/// Rectangles of cells that the plane through home across axis `across` cuts.
std::string cut(const Axes& axes, const std::vector<PoseCell>& cells, int across) {
  std::string text = "[";
  const int u = axes.first + (across + 1) % 3, v = axes.first + (across + 2) % 3, w = axes.first + across;
  for (const PoseCell& c : cells) {
    const double from_low = -(c.centre[w] - c.half[w]), to_high = c.centre[w] + c.half[w];
    if (from_low < 0 || to_high <= 0) continue;
    const std::array<double, 4> rectangle{c.centre[u] - c.half[u], c.centre[v] - c.half[v], 2 * c.half[u], 2 * c.half[v]};
    text += (text.size() > 1 ? "," : "") + list(rectangle, axes.scale);
  }
  return text + "]";
}

/// Values at one pose: greatest force all round [N] with the required torque, isotropy, least stiffness of the strings [N/m].
struct Values {
  double force = 0, isotropy = 0, stiffness = 0;
};

Values valuesAt(const DeviceDef& def, const CellJudge& judge, const Vector6& at) {
  PoseCell point;
  point.centre = at;
  RowBounds rows;
  judge.rows().evaluate(point, rows);
  if (!rows.bounded) return {};
  const StringKinematics kinematics(def);
  const Eigen::VectorXd singular = kinematics.singularValues(point.pose());
  const StringVector length = kinematics.lengths(point.pose());
  Matrix3 stiffness = Matrix3::Zero();
  for (int i = 0; i < rows.strings; ++i) {
    const Vector3 d = rows.row[i].head<3>();
    stiffness += def.strings[i].min_tension / length[i] * (Matrix3::Identity() - d * d.transpose());
  }
  return {judge.set().largestForce(rows), singular[singular.size() - 1] / singular[0], eigenvalues(stiffness).minCoeff()};
}

/// One section of a region through home: cells, and values on a grid of samples, row by row.
std::string section(const DeviceDef& def, const CellJudge& judge, const Workspace& w, int across) {
  const Axes axes(w.searched);
  const int u = axes.first + (across + 1) % 3, v = axes.first + (across + 2) % 3;
  std::vector<double> force, isotropy, stiffness;
  for (int code = 0; code < kSamples * kSamples; ++code) {
    Vector6 at = Vector6::Zero();
    at[u] = w.searched.centre[u] + w.searched.half[u] * ((code % kSamples + 0.5) * 2 / kSamples - 1);
    at[v] = w.searched.centre[v] + w.searched.half[v] * ((code / kSamples + 0.5) * 2 / kSamples - 1);
    const Values values = valuesAt(def, judge, at);
    force.push_back(values.force);
    isotropy.push_back(values.isotropy);
    stiffness.push_back(values.stiffness);
  }
  return "{\"across\":" + std::to_string(across) + ",\"inside\":" + cut(axes, w.inside, across) +
         ",\"undecided\":" + cut(axes, w.undecided, across) + ",\"samples\":" + std::to_string(kSamples) + ",\"force\":" + list(force) +
         ",\"isotropy\":" + list(isotropy) +
         ",\"stiffness\":" + list(stiffness) + "}";
}

/// The pairs of strings that come nearest over the certified cells, and the strings that lie flattest on the grip's ball.
std::string nearestPairs(const DeviceDef& def, const Workspace& w) {
  constexpr int kShown = 4;  // of each kind
  std::string text = "[";
  int strings = 0, grips = 0;
  for (const Nearest& n : nearestOver(def, w.inside)) {
    if (++(n.second < 0 ? grips : strings) > kShown) continue;
    text += (text.size() > 1 ? ",{\"first\":" : "{\"first\":") + std::to_string(n.first) +
            ",\"second\":" + std::to_string(n.second) + ",\"atLeast\":" + number(1e3 * n.at_least) +
            ",\"found\":" + number(1e3 * n.found) + ",\"at\":" + Axes(w.searched).of(n.at) + "}";
  }
  return text + "]";
}

std::string region(const DeviceDef& def, const RequiredWrench& required, const PoseCell& searched) {
  WorkspaceSettings settings;
  settings.required = required;
  const std::clock_t start = std::clock();
  const Workspace w = certifyWorkspace(def, searched, settings);
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  const CellJudge judge(def, searched, settings);
  const Axes axes(searched);
  std::string text = std::string("{\"kind\":") + (axes.first == 0 ? "\"translations\"" : "\"turns\"") +
                     ",\"searched\":" + boxText(axes, searched) + ",\"inside\":" + number(w.inside_share) +
                     ",\"undecided\":" + number(w.undecided_share) +
                     ",\"exhausted\":" + (w.exhausted ? "true" : "false") + ",\"seconds\":" + number(seconds) +
                     ",\"cells\":" + std::to_string(w.inside.size() + w.outside.size() + w.undecided.size()) +
                     ",\"volume\":" + number(w.inside_share * searched.volume() * axes.scale * axes.scale * axes.scale) +
                     ",\"width\":" + number(w.undecided.empty() ? 0 : 2 * axes.scale * w.undecided[0].half.maxCoeff()) +
                     ",\"ball\":" + boxText(axes, w.ball) + ",\"homeBall\":" + boxText(axes, w.home_ball) +
                     ",\"box\":" + boxText(axes, w.box) + ",\"homeBox\":" + boxText(axes, w.home_box) + ",\"nearest\":" +
                     nearestPairs(def, w) + ",\"sections\":[";
  for (int across = 0; across < 3; ++across) text += (across ? "," : "") + section(def, judge, w, across);
  text += "],\"border\":[";
  const std::size_t stride = 1 + w.undecided.size() / kBorderCells;
  for (std::size_t i = 0; i < w.undecided.size(); i += stride) text += (i ? "," : "") + axes.of(w.undecided[i].centre);
  return text + "]}";
}

}  // namespace

RequiredWrench leastFeedback(const DeviceDef& def) {
  const double force = std::min(1.0, 0.1 * def.strings[0].max_tension);
  return {force, def.dof == 3 ? 0 : force * StringKinematics(def).knotRadius()};
}

std::string deviceReport(const DeviceDef& def, const RequiredWrench& required) {
  WorkspaceSettings settings;
  settings.required = {0, 0};
  const CellJudge alone(def, PoseCell{}, settings);
  settings.required = required;
  const CellJudge judge(def, PoseCell{}, settings);
  RowBounds home;
  alone.rows().evaluate(PoseCell{}, home);
  const Values values = valuesAt(def, judge, Vector6::Zero());
  std::string text = "{\"name\":" + quoted(def.name) + ",\"file\":" + quoted(def.file) + ",\"source\":" + quoted(def.source) +
                     ",\"dof\":" + std::to_string(def.dof) + ",\"required\":{\"force\":" + number(required.force) +
                     ",\"torque\":" + number(required.torque) + "},\"strings\":[";
  for (std::size_t i = 0; i < def.strings.size(); ++i) {
    const StringDef& s = def.strings[i];
    const Vector3 knot = def.dof == 3 ? Vector3(Vector3::Zero()) : s.p_GK;
    text += (i ? ",{\"exit\":" : "{\"exit\":") + list(s.p_BE, 1e3) + ",\"knot\":" + list(knot, 1e3) +
            ",\"least\":" + number(s.min_tension) + ",\"most\":" + number(s.max_tension) + "}";
  }
  text += "],\"home\":{\"force\":" + number(alone.set().largestForce(home)) +
          ",\"torque\":" + number(def.dof == 3 ? 0 : alone.set().largestTorque(home)) +
          ",\"both\":" + number(values.force) + ",\"singular\":" + list(StringKinematics(def).singularValues(GripPose{})) +
          ",\"isotropy\":" + number(values.isotropy) + ",\"stiffness\":" + number(values.stiffness) + "},\"regions\":[" +
          region(def, required, translations(def));
  if (def.dof >= 6) text += "," + region(def, required, rotations());
  return text + "]}\n";
}

}  // namespace haptic
