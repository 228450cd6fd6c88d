/// Stacks of 2 to 6 bodies of any size and weight on a floor, as URDF: the same ones on every machine.
#pragma once
#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>
#include <string>

namespace haptic::bench {

/// `contact`: what all of them say of their surfaces, within <haptic:scene>; empty: nothing.
inline std::string randomStack(std::mt19937& random, const std::string& contact = "") {
  const auto uniform = [&](double low, double high) { return low + (high - low) * (random() / 4294967296.0); };
  const auto size = [&] { return std::pow(10, uniform(-1.5, -0.6)); };
  std::ostringstream text;
  text << "<robot name=\"stack\" xmlns:haptic=\"h\">" << (contact.empty() ? "" : "<haptic:scene>" + contact + "</haptic:scene>")
       << "<link name=\"world\"/><link name=\"floor\"><collision><geometry><box size=\"4 4 0.2\"/></geometry></collision></link>"
          "<joint name=\"f\" type=\"fixed\"><origin xyz=\"0 0 -0.1\"/><parent link=\"world\"/><child link=\"floor\"/></joint>\n";
  const int bodies = 2 + static_cast<int>(random() % 5);
  double top = 0, x = 0, y = 0, width = 1;
  for (int i = 0; i < bodies; ++i) {
    const double m = std::pow(10, uniform(-1, 3)), a = size(), b = size(), c = random() % 4 == 0 ? 0.1 * size() : size();
    x += uniform(-0.15, 0.15) * std::min(a, width), y += uniform(-0.15, 0.15) * std::min(b, width);
    width = std::min(a, b);
    const bool round = random() % 4 == 0;
    text << "<link name=\"b" << i << "\"><inertial><mass value=\"" << m << "\"/><inertia ixx=\"" << m * (b * b + c * c) / 12 << "\" iyy=\""
         << m * (a * a + c * c) / 12 << "\" izz=\"" << m * (a * a + b * b) / 12
         << "\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial><collision><geometry>";
    if (round) {
      text << "<cylinder radius=\"" << width / 2 << "\" length=\"" << c << "\"/>";
    } else {
      text << "<box size=\"" << a << " " << b << " " << c << "\"/>";
    }
    text << "</geometry></collision></link><joint name=\"j" << i << "\" type=\"floating\"><origin xyz=\"" << x << " " << y << " "
         << top + c / 2 << "\"/><parent link=\"world\"/><child link=\"b" << i << "\"/></joint>\n";
    top += c;
  }
  return text.str() + "</robot>\n";
}

}  // namespace haptic::bench
