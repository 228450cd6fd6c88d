// The functions that JavaScript calls: one scene or session at a time. Texts and numbers stay where they are until the next call.
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>

#include "browser/touch.h"
#include "haptic_core/base/error.h"
#include "scene/hand_on_path.h"

namespace haptic {
namespace {

std::unique_ptr<Touch> touch;
std::unique_ptr<Again> again;
std::unique_ptr<World> alone;  ///< a world without devices, whose hands follow their paths: what builds are compared with
SceneDef alone_scene;
std::string bytes, text;
std::vector<double> numbers, drawn;

/// Empty, or the error that stopped `act`, in a line.
template <class Act>
const char* refused(Act act) {
  text.clear();
  try {
    act();
  } catch (const std::exception& error) {
    text = error.what();
  }
  return text.c_str();
}

const SceneDef& scene() { return touch ? touch->packed().scene : again->session().scene.scene; }

}  // namespace
}  // namespace haptic

using namespace haptic;

extern "C" {

/// Room for so many bytes of a packed scene.
char* haptic_room(int count) {
  bytes.assign(static_cast<std::size_t>(count), '\0');
  return bytes.data();
}
/// Opens the scene whose bytes are in the room: empty, or one line why not.
const char* haptic_open() {
  touch.reset(), again.reset();
  return refused([] { touch = std::make_unique<Touch>(unpackScene(bytes, "this scene")); });
}
/// The same for a session.
const char* haptic_open_session() {
  touch.reset(), again.reset();
  return refused([] { again = std::make_unique<Again>(unpackSession(bytes, "this session")); });
}
const char* haptic_about() {
  text = touch ? pictureText(scene(), touch->loop().world(), touch->hands(), touch->packed().about)
               : pictureText(scene(), again->loop().world(), again->hands(), again->session().scene.about);
  return text.c_str();
}
/// Corners of a visual, nine numbers a triangle [m]: so many doubles at haptic_numbers.
int haptic_corners(int visual) {
  numbers.clear();
  for (const Vector3& corner : scene().visuals.at(static_cast<std::size_t>(visual)).corners) {
    numbers.insert(numbers.end(), {corner.x(), corner.y(), corner.z()});
  }
  return static_cast<int>(numbers.size());
}
const double* haptic_numbers() { return numbers.data(); }
void haptic_ticks(int count) {
  for (int i = 0; i < count; ++i) touch ? touch->tick() : again->tick();
}
int haptic_picture() {
  touch ? Picture::draw(touch->loop(), touch->hands(), drawn) : Picture::draw(again->loop(), again->hands(), drawn);
  return static_cast<int>(drawn.size());
}
const double* haptic_drawn() { return drawn.data(); }

void haptic_aim(int hand, double x, double y, double z) { touch->aim(hand, {x, y, z}); }
void haptic_let_go(int hand) { touch->letGo(hand); }
/// Where the hand is led [m], and 1 if it is.
const double* haptic_aimed(int hand) {
  const Vector3 p_W = touch->aimed(hand);
  numbers = {p_W.x(), p_W.y(), p_W.z(), static_cast<double>(touch->led(hand))};
  return numbers.data();
}
const char* haptic_tune(double stiffness, double friction) {
  return refused([&] { touch->tune(stiffness, friction); });
}
/// Error of position [m], of the force on the first hand [N]; NaN: unknown.
const double* haptic_estimate() {
  numbers.assign(2, std::nan(""));
  refused([] {
    const ErrorEstimate error = touch->estimate();
    numbers = {error.position, error.force.empty() ? std::nan("") : error.force[0]};
  });
  return numbers.data();
}

/// Of a session: ticks recorded, done, compared, the same.
const double* haptic_progress() {
  numbers = {static_cast<double>(again->ticks()), static_cast<double>(again->done()), static_cast<double>(again->compared()),
             static_cast<double>(again->same())};
  return numbers.data();
}

/// The world of the bytes in the room, alone, its hands on their paths: empty, or one line why not.
const char* haptic_alone() {
  return refused([] {
    alone_scene = unpackScene(bytes, "this scene").scene;
    alone = std::make_unique<World>(alone_scene.world);
  });
}
void haptic_alone_steps(int count) {
  for (int i = 0; i < count; ++i) {
    followPaths(alone_scene, *alone);
    alone->step();
  }
}
const char* haptic_alone_hash() {
  char hash[17];
  std::snprintf(hash, sizeof hash, "%016" PRIx64, alone->hash());
  return (text = hash).c_str();
}
}
